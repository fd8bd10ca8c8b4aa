"""Messages to a service manager."""

import socket

import pytest

from subsea.stage.service import PictureReports, notify


@pytest.fixture(params=["file", "abstract"])
def manager(request, tmp_path, monkeypatch):
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as one:
        name = f"{tmp_path}/notify"
        one.bind(name if request.param == "file" else f"\0{name}")
        one.setblocking(False)
        monkeypatch.setenv("NOTIFY_SOCKET", name if request.param == "file" else f"@{name}")
        yield one


def received(manager):
    found = []
    while True:
        try:
            found.append(manager.recv(4096).decode().split("\n"))
        except BlockingIOError:
            return found


def test_a_message_has_a_field_in_each_line(manager):
    notify(READY=1, STATUS="two\nlines")
    assert received(manager) == [["READY=1", "STATUS=two?lines"]]


def test_only_new_pictures_are_reported_at_most_once_a_second(manager):
    reports = PictureReports()
    reports.update(0, "loading", 0.0)
    assert received(manager) == []
    reports.update(1, "reef", 5.0)
    assert received(manager) == [["READY=1", "WATCHDOG=1", "STATUS=reef"]]
    reports.update(9, "reef", 5.9)
    reports.update(9, "reef", 6.5)
    reports.update(9, "reef", 60.0)  # it shows no picture any more
    assert received(manager) == [["WATCHDOG=1", "STATUS=reef, 5.3 pictures a second"]]


@pytest.mark.parametrize("address", ["", "/nowhere/notify", "x" * 200, "@"])
def test_without_a_manager_nothing_happens(address, monkeypatch):
    monkeypatch.setenv("NOTIFY_SOCKET", address)
    notify(READY=1)


def test_a_manager_that_does_not_read_is_not_waited_for(manager):
    for _ in range(5000):
        notify(STATUS="x" * 1000)
    assert received(manager)
