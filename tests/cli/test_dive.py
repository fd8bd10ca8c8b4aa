"""Options of `subsea dive --console`: each fault is one line before a window opens."""

import pytest

from subsea.base import system as extras
from subsea.cli.main import main


def refusal(capsys, *options):
    assert main(["dive", *options]) == 2
    told = capsys.readouterr().err.strip()
    assert "\n" not in told
    return told


@pytest.mark.parametrize(
    "option",
    [["--console-osc"], ["--console-token", "x"], ["--console-name", "x"],
     ["--console-tls", "cert.pem", "key.pem"]],
)  # fmt: skip
def test_its_options_need_it(capsys, option):
    assert f"{option[0]} needs --console" in refusal(capsys, *option)


def test_other_computers_need_tls(capsys):
    told = refusal(capsys, "--console", "0.0.0.0:8880")
    assert "expected --console-tls CERTIFICATE KEY" in told


@pytest.mark.parametrize("address", ["nowhere", "1.2.3.4", "127.0.0.1:x"])
def test_an_address_has_a_port(capsys, address):
    assert "expected an IP address and a port" in refusal(capsys, "--console", address)


def test_a_missing_extra_is_named_with_its_command(capsys, monkeypatch):
    monkeypatch.setitem(extras.EXTRAS, "console", {"no_such_module": "aiohttp"})
    assert "--console needs aiohttp: run `make bench`" in refusal(capsys, "--console")
