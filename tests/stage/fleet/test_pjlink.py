"""Commands of PJLink against a projector written from the specification; faults of its answers."""

import time
from contextlib import closing

import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.stage.fleet.pjlink import (
    PjlinkConnection,
    ProjectorStatus,
    errors_of,
    lamps_of,
    read_password,
)
from tests.stage.fleet.pjlink_server import PASSWORD, ProjectorServer

LIMIT_S = 20.0


@pytest.fixture
def projector():
    with closing(ProjectorServer()) as made:
        yield made


def connected(projector, password="", limit_s=LIMIT_S):
    return closing(PjlinkConnection(("127.0.0.1", projector.port), password, limit_s))


def test_status_and_power(projector):
    projector.answers["ERST ?"] = "010002"
    with connected(projector) as connection:
        assert connection.status() == ProjectorStatus(
            "off", ((1234, False), (567, False)), (("lamp", "warning"), ("other", "error"))
        )
        connection.switch(True)
        assert connection.status().power == "warming"
        connection.switch(False)
        assert connection.status().power == "cooling"
    assert projector.asked[:4] == ["POWR ?", "LAMP ?", "ERST ?", "POWR 1"]


def test_a_password_is_sent_as_the_digest_of_the_specification(projector):
    projector.guarded = True
    with connected(projector, PASSWORD) as connection:
        assert connection.status().power == "off"
    wrong = pytest.raises(UserError, match="refuses the password")
    with connected(projector, "wrong") as connection, wrong:
        connection.status()
    with pytest.raises(UserError, match="asks for a password: name its file as `password`"):
        connected(projector)


def test_a_projector_without_lamps_in_standby(projector):
    projector.answers |= {"LAMP ?": "ERR1", "ERST ?": "ERR3"}
    with connected(projector) as connection:
        assert connection.status() == ProjectorStatus("off")


@pytest.mark.parametrize(
    ("answer", "words"),
    [("ERR3", "cannot do that now"), ("ERR4", "reports a failure of its own"),
     ("ERR2", "refuses the value"), ("maybe", "something else than PJLink: 'MAYBE'")],
)  # fmt: skip
def test_a_switch_that_is_refused(projector, answer, words):
    projector.answers["POWR 1"] = answer
    with connected(projector) as connection, pytest.raises(UserError, match=words):
        connection.switch(True)


@pytest.mark.parametrize(
    ("garbage", "words"),
    [(b"SSH-2.0-OpenSSH_9.2\r\n", "something else than PJLink: 'SSH-2.0"),
     (b"\x00\xff" * 5000, "something else than PJLink"), (b"PJLINK 7\r", "PJLINK 7")],
)  # fmt: skip
def test_another_program_at_the_port(projector, garbage, words):
    projector.garbage = garbage
    with pytest.raises(UserError, match=words):
        connected(projector)


def test_a_silent_projector_holds_nobody_up(projector):
    projector.silent = True
    begun = time.monotonic()
    with pytest.raises(UserError, match=r"does not answer \(too slow\)"):
        connected(projector, limit_s=0.2)
    assert time.monotonic() - begun < 10.0


def test_a_port_where_nobody_listens():
    gone = ProjectorServer()
    gone.close()
    with pytest.raises(UserError, match="does not answer"):
        connected(gone)


@given(st.text(max_size=40))
def test_garbage_is_refused_or_read(text):
    for read in (lamps_of, errors_of):
        try:
            read(text)
        except UserError as fault:
            assert "something else than PJLink" in str(fault)


def test_a_password_must_be_the_users_own(tmp_path):
    file = tmp_path / "password"
    file.write_text(f"{PASSWORD}\n")
    file.chmod(0o644)
    with pytest.raises(UserError, match=r"password: others may read it .*chmod 600"):
        read_password(file)
    file.chmod(0o600)
    assert read_password(file) == PASSWORD
    file.write_text("x" * 33)
    with pytest.raises(UserError, match="password: expected a password of 1 to 32 letters"):
        read_password(file)
