"""Addresses, tokens and certificates of the console."""

import stat
import subprocess

import pytest

from subsea.base.errors import UserError
from subsea.stage.console.options import console_options, make_token, read_token, token_path
from tests.stage.console.conftest import TOKEN


def refusal(*arguments):
    with pytest.raises(UserError) as fault:
        console_options(*arguments)
    return str(fault.value)


@pytest.fixture
def token_file(tmp_path):
    path = tmp_path / "token"
    path.write_text(f"{TOKEN}\n")
    path.chmod(0o600)
    return path


@pytest.mark.parametrize("address", ["127.0.0.1:8880", "127.1.2.3:1", "[::1]:8880"])
def test_on_this_computer_nothing_is_needed(address):
    options, lines = console_options(address, None, None, None)
    assert options.url == f"http://{address}/" and not options.token and not lines


@pytest.mark.parametrize(
    "address", ["0.0.0.0:8880", "192.168.1.7:8880", "[::]:8880", "[fe80::1]:1"]
)
def test_other_computers_need_tls(address, token_file):
    assert "expected --console-tls CERTIFICATE KEY" in refusal(address, None, token_file, None)


@pytest.mark.parametrize(
    "address", ["8880", "localhost:8880", "127.0.0.1:0", "127.0.0.1:70000", ""]
)
def test_other_addresses_are_refused(address):
    assert "--console: address" in refusal(address, None, None, None)


@pytest.mark.parametrize("address", ["0.0.0.0:8881", "192.168.1.7:8881"])
def test_osc_is_for_this_computer_only(address, token_file, certificate):
    told = refusal("0.0.0.0:8880", address, token_file, certificate)
    assert "OSC has no passwords" in told


def test_a_token_is_generated_once_for_the_user_alone(certificate, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    options, lines = console_options("0.0.0.0:8880", None, None, certificate)
    path = token_path()
    assert len(options.token) >= 43 and lines == [f"the token of the console is in {path}"]
    assert options.token not in lines[0]
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    again, _ = console_options("0.0.0.0:8880", None, None, certificate)
    assert again.token == options.token != make_token(tmp_path / "other")


@pytest.mark.parametrize(
    ("content", "mode", "words"),
    [
        (TOKEN, 0o644, "others may read it (mode 644); `chmod 600"),
        (TOKEN, 0o640, "others may read it"),
        ("short", 0o600, "expected a token of 32 to 256"),
        ("", 0o600, "expected a token"),
        ("é" * 40, 0o600, "expected a token"),
        ("two\nlines" * 10, 0o600, "expected a token"),
        ("a" * 300, 0o600, "expected a token"),
    ],
)
def test_a_bad_token_file_is_refused(tmp_path, content, mode, words):
    path = tmp_path / "token"
    path.write_text(content)
    path.chmod(mode)
    with pytest.raises(UserError) as fault:
        read_token(path)
    assert words in str(fault.value) and str(path) in str(fault.value)


def test_a_missing_token_file_is_refused(tmp_path):
    assert "no such file" in refusal("127.0.0.1:8880", None, tmp_path / "none", None)


def test_a_bad_certificate_is_refused(certificate, tmp_path, token_file):
    garbage, locked = tmp_path / "garbage.pem", tmp_path / "locked.pem"
    garbage.write_bytes(b"\x00garbage" * 100)
    subprocess.run(
        ["openssl", "ec", "-aes128", "-passout", "pass:secret", "-in", certificate[1],
         "-out", locked], check=True, capture_output=True,
    )  # fmt: skip
    address = "0.0.0.0:8880"
    missing = tmp_path / "none.pem"
    assert "no such file" in refusal(address, None, token_file, (missing, certificate[1]))
    assert "folder" in refusal(address, None, token_file, (tmp_path, certificate[1]))
    for pair in ((garbage, certificate[1]), (certificate[0], garbage), (certificate[0],) * 2):
        assert "no certificate whose key is" in refusal(address, None, token_file, pair)
    told = refusal(address, None, token_file, (certificate[0], locked))
    assert f"{locked}: needs a password, expected a key without" in told
