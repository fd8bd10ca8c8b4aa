"""Addresses, token and certificate of the console: the options of `subsea dive --console`."""

import ipaddress
import secrets
import ssl
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, NoReturn

import platformdirs

from subsea.base.errors import UserError, unreadable
from subsea.base.files import OWN_MODE, check_input, read_text, refuse_shared, replacing
from subsea.stage.theatre.theatre_file import parse_address

TOKEN_BYTES = 32  # of a generated token
SHORTEST_TOKEN, LONGEST_TOKEN = 32, 256  # characters of one in a file


class ListenAddress(NamedTuple):
    """An IP address and a port."""

    ip: ipaddress.IPv4Address | ipaddress.IPv6Address
    port: int

    def __str__(self) -> str:
        """The address as in a URL."""
        return f"[{self.ip}]:{self.port}" if self.ip.version == 6 else f"{self.ip}:{self.port}"


@dataclass(frozen=True)
class ConsoleOptions:
    """The places of the console, its token and its certificate."""

    http: ListenAddress
    osc: ListenAddress | None = None  # None: no OSC
    token: str = ""  # empty: everybody on this computer may come
    tls: ssl.SSLContext | None = None
    names: tuple[str, ...] = ()  # host names beside addresses under which it may be called

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http{'s' * (self.tls is not None)}://{self.http}/"


def console_options(
    http: str, osc: str | None, token_file: Path | None, tls: tuple[Path, Path] | None,
    names: tuple[str, ...] = (),
) -> tuple[ConsoleOptions, list[str]]:  # fmt: skip
    """Check the options; returns them and lines to report.

    An address that other computers can reach needs TLS files, certificate and key, and a token:
    that of a file, else one that is generated in the user's folder of settings. UserErrors.
    """
    place, lines = _place(http, "--console"), []
    heard = None if osc is None else _place(osc, "--console-osc")
    if heard is not None and not heard.ip.is_loopback:
        raise UserError(
            f"--console-osc {osc}: other computers reach it and OSC has no passwords: "
            "expected an address of this computer, such as 127.0.0.1"
        )
    if not place.ip.is_loopback and tls is None:
        raise UserError(
            f"--console {http}: other computers reach it: expected --console-tls CERTIFICATE KEY"
        )
    token = ""
    if token_file is not None:
        token = read_token(token_file)
    elif not place.ip.is_loopback:
        path = token_path()
        token = read_token(path) if path.exists() else make_token(path)
        lines.append(f"the token of the console is in {path}")
    context = None if tls is None else _tls(*tls)
    return ConsoleOptions(place, heard, token, context, names), lines


def token_path() -> Path:
    """The file of the generated token, which may be missing."""
    return platformdirs.user_config_path("subsea", appauthor=False) / "console-token"


def make_token(path: Path) -> str:
    """Write a new random token to a file that only the user can read; returns it."""
    token = secrets.token_urlsafe(TOKEN_BYTES)
    with replacing(path, OWN_MODE) as part:
        part.write_text(f"{token}\n", encoding="ascii")
    return token


def read_token(path: Path) -> str:
    """Read a token; a UserError if it is short or if others may read the file."""
    text = read_text(path).strip()
    refuse_shared(path)
    if not (SHORTEST_TOKEN <= len(text) <= LONGEST_TOKEN and text.isascii() and text.isprintable()):
        raise UserError(
            f"expected a token of {SHORTEST_TOKEN} to {LONGEST_TOKEN} letters and digits", file=path
        )
    return text


def _place(text: str, option: str) -> ListenAddress:
    try:
        return ListenAddress(*parse_address(text))
    except ValueError as fault:
        raise UserError(f"{option}: {fault}") from fault


def _tls(certificate: Path, key: Path) -> ssl.SSLContext:
    """The TLS settings of a certificate with its key; a UserError if they do not fit."""
    for path in (certificate, key):
        check_input(path)

    def refuse() -> NoReturn:
        raise UserError("needs a password, expected a key without", file=key)

    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(certificate, key, refuse)
    except ssl.SSLError as fault:
        raise UserError(
            f"no certificate whose key is {key}, both in PEM ({fault.reason or 'not PEM'})",
            file=certificate,
        ) from fault
    except OSError as fault:
        raise unreadable(certificate, fault) from fault
    return context
