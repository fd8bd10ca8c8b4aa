"""The text of a unit, and messages to a service manager; test_kiosk_service.py runs both."""

import configparser
import re
import shlex
import socket
from pathlib import Path

import pytest

from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.stage.service import PictureReports, notify, unit_path, unit_text


def command(text):
    parser = configparser.RawConfigParser(strict=False)
    parser.optionxform = str
    parser.read_string(text)
    return parser["Service"]["ExecStart"]


def test_files_have_absolute_paths_and_names_stay(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["--kiosk", "--scenario", "mine.toml", "--theatre=hall.toml", "--node", "left"]
    found = shlex.split(command(unit_text(words, "left")))
    assert Path(found[0]).is_absolute() and found[1:5] == ["-P", "-m", "subsea", "dive"]
    assert found[5:] == [
        "--kiosk", "--scenario", f"{tmp_path}/mine.toml", f"--theatre={tmp_path}/hall.toml",
        "--node", "left",
    ]  # fmt: skip
    assert "--scenario peaceful" in command(unit_text(["--scenario", "peaceful"]))


def test_odd_letters_are_escaped_as_systemd_reads_them():
    found = command(unit_text(["--scenario", "/a b/100%/$x/'\"\\.toml"]))
    assert found.endswith("""--scenario "/a b/100%%/$$x/'\\"\\\\.toml\"""")
    with pytest.raises(UserError, match="printable"):
        unit_text(["--scenario", "/a\nb.toml"])


def test_a_unit_starts_again_for_ever():
    text = unit_text(["--scenario", "peaceful"])
    limit = re.search(r"^StartLimitIntervalSec=(.*)$", text, re.MULTILINE)
    assert limit is not None and limit[1] == "0" and "StartLimitBurst" not in text
    assert "Restart=on-failure" in text and "RestartPreventExitStatus=2\n" in text


def test_each_node_has_a_unit_of_its_own(monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", "/home/me/.config")
    assert str(unit_path(None)) == "/home/me/.config/systemd/user/subsea.service"
    assert unit_path("left").name == "subsea-left.service"


@pytest.mark.parametrize("kiosk", [[], ["--kiosk"]])
@pytest.mark.parametrize(
    ("words", "name"),
    [
        (["--scenario", "peaceful"], "subsea"),
        (["--theatre", "three-computers", "--node", "middle"], "subsea-middle"),
        (["--theatre", "three-computers", "--node", "left"], "subsea-left"),
    ],
)
def test_units_of_one_computer_a_master_and_a_node(
    words, name, kiosk, tmp_path, monkeypatch, capsys
):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert main(["dive", *words, *kiosk, "--write-unit"]) == 0
    out = capsys.readouterr().out
    path = tmp_path / "systemd/user" / f"{name}.service"
    assert out.splitlines()[0] == str(path)
    assert f"systemctl --user enable --now {name}" in out
    found = shlex.split(command(path.read_text()))
    assert found[5:] == [*words, *kiosk]
    assert main(["dive", *words, *kiosk, "--write-unit"]) == 0  # replaces its own


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
