"""Threads that watch projectors: one that is gone, back, or refuses, while others go on."""

import time
from contextlib import closing

import pytest

from subsea.base.errors import UserError
from subsea.stage.fleet.projectors import Projectors, read_passwords
from subsea.stage.theatre.theatre_file import ProjectorTable
from tests.stage.fleet.pjlink_server import PASSWORD, ProjectorServer


def until(true):
    end = time.monotonic() + 30.0
    while not (value := true()):
        assert time.monotonic() < end
        time.sleep(0.01)
    return value


@pytest.fixture
def servers():
    with closing(ProjectorServer()) as left, closing(ProjectorServer(guarded=True)) as right:
        yield {"left": left, "right": right}


@pytest.fixture
def watched(servers):
    tables = [ProjectorTable(name=name, address="127.0.0.1", port=one.port)
              for name, one in servers.items()]  # fmt: skip
    with closing(Projectors(tables, ["", PASSWORD], 0.05)) as made:
        yield made


def state(watched, name):
    return next(one for one in watched.describe() if one["name"] == name)


def test_power_lamps_and_errors_are_known(watched, servers):
    until(lambda: state(watched, "right")["power"] == "off")
    assert state(watched, "right")["lamps"][0] == {"hours": 1234, "on": False}
    assert watched.switch("all", True) == "switches all projectors on"
    until(lambda: state(watched, "left")["power"] == state(watched, "right")["power"] == "warming")
    servers["left"].answers |= {"POWR ?": "1", "ERST ?": "200000"}
    until(lambda: state(watched, "left")["errors"] == [{"part": "fan", "severity": "error"}])
    assert watched.switch("right", False) == "switches projector right off"
    until(lambda: state(watched, "right")["power"] == "cooling")
    assert watched.check() == []


def test_a_projector_that_is_gone_and_back_is_a_line_each(watched, servers):
    until(lambda: state(watched, "left")["power"] == "off")
    servers["left"].close()
    [line] = until(watched.check)
    assert line.startswith("projector left: does not answer (")
    assert line.endswith("; the show goes on")
    gone = state(watched, "left")
    assert gone["power"] == "unknown"
    assert gone["seen"]
    time.sleep(0.3)
    assert watched.check() == []  # not again and again
    servers["left"].reopen()
    assert until(watched.check) == ["projector left: answers again"]


def test_a_switch_that_fails_is_a_line_and_is_not_repeated(watched, servers):
    until(lambda: state(watched, "left")["power"] == "off")
    servers["left"].answers["POWR 1"] = "ERR3"
    watched.switch("left", True)
    assert until(watched.check) == ["projector left: not switched on, it cannot do that now"]
    until(lambda: state(watched, "left")["power"] == "off")
    assert servers["left"].asked.count("POWR 1") == 1


def test_unknown_names_are_refused(watched):
    with pytest.raises(UserError, match="unknown projector 'lift'; did you mean 'left'"):
        watched.switch("lift", True)
    with closing(Projectors([], [])) as none, pytest.raises(UserError, match=r"no \[\[projector"):
        none.switch("all", True)


def test_passwords_are_found_beside_the_theatre_file(tmp_path):
    (tmp_path / "secret").write_text(PASSWORD)
    (tmp_path / "secret").chmod(0o600)
    tables = [ProjectorTable(name="left", address="10.0.0.1"),
              ProjectorTable(name="right", address="10.0.0.2", password="secret")]  # fmt: skip
    assert read_passwords(tables, tmp_path / "hall.toml") == ["", PASSWORD]
    (tmp_path / "secret").unlink()
    with pytest.raises(UserError, match="secret: no such file"):
        read_passwords(tables, tmp_path / "hall.toml")
