"""Speak PJLink class 1 with a projector: PJLink Specifications 1.04, JBMIA, 2013.

A line ends with a carriage return. The projector greets with ``PJLINK 0``, or with ``PJLINK 1`` and
a random number: then the first command follows the MD5 digest of that number and the password.
"""

import re
import socket
import time
from dataclasses import dataclass
from hashlib import md5
from pathlib import Path

from subsea.base.errors import UserError, printable
from subsea.base.files import read_text, refuse_shared

MOST_BYTES = 200  # of a line; class 1 has 136
MOST_LAMPS = 8
GREETING = re.compile(r"PJLINK (?:0|1 (?P<number>\S{1,32}))", re.IGNORECASE)
POWER = {"0": "off", "1": "on", "2": "cooling", "3": "warming"}
PARTS = ("fan", "lamp", "temperature", "cover", "filter", "other")
SEVERITY = {"0": "", "1": "warning", "2": "error"}
ERRORS = {
    "ERR1": "does not know the command",
    "ERR2": "refuses the value",
    "ERR3": "cannot do that now",
    "ERR4": "reports a failure of its own",
}
UNKNOWN = "ERR1", "ERR3"  # a projector without lamps, or one in standby


@dataclass(frozen=True)
class ProjectorStatus:
    """The answers of a projector."""

    power: str  # a value of POWER
    lamps: tuple[tuple[int, bool], ...] = ()  # hours, and True if it is lit; empty: unknown
    errors: tuple[tuple[str, str], ...] = ()  # parts with their severity, without those in order


class PjlinkConnection:
    """A connection for a few commands; every fault is a UserError without the projector's name."""

    def __init__(self, place: tuple[str, int], password: str, limit_s: float) -> None:
        """Connect; all commands together may take `limit_s`, however slowly bytes trickle in."""
        self._end = time.monotonic() + limit_s
        self._rest = b""
        try:
            self._socket = socket.create_connection(place, limit_s)
        except OSError as fault:
            raise UserError(f"does not answer ({_reason(fault)})") from fault
        try:
            self._digest = self._greeted(self._line(), password)
        except BaseException:
            self._socket.close()
            raise

    def close(self) -> None:
        """End the connection."""
        self._socket.close()

    def status(self) -> ProjectorStatus:
        """Ask for power, lamps and errors."""
        power = _accepted(self._ask("POWR", "?"))
        if power not in POWER:
            raise _rubbish(power)
        lamps, errors = self._ask("LAMP", "?"), self._ask("ERST", "?")
        return ProjectorStatus(
            POWER[power],
            () if lamps in UNKNOWN else lamps_of(_accepted(lamps)),
            () if errors in UNKNOWN else errors_of(_accepted(errors)),
        )

    def switch(self, on: bool) -> None:
        """Switch it on, or to standby."""
        answer = _accepted(self._ask("POWR", "1" if on else "0"))
        if answer != "OK":
            raise _rubbish(answer)

    def _greeted(self, line: str, password: str) -> str:
        """The digest before the first command; empty if none is needed."""
        greeting = GREETING.fullmatch(line)
        if greeting is None:
            raise _rubbish(line)
        number = greeting["number"]
        if number is None:
            return ""
        if not password:
            raise UserError("asks for a password: name its file as `password` of [[projector]]")
        return md5((number + password).encode(), usedforsecurity=False).hexdigest()

    def _ask(self, command: str, value: str) -> str:
        """Send a command and return what comes after the equals sign."""
        try:
            self._socket.sendall(f"{self._digest}%1{command} {value}\r".encode())
        except OSError as fault:
            raise UserError(f"does not answer ({_reason(fault)})") from fault
        self._digest = ""
        line = self._line()
        if line.upper() == "PJLINK ERRA":
            raise UserError("refuses the password")
        head, equals, answer = line.partition("=")
        if not equals or head.upper() != f"%1{command}":
            raise _rubbish(line)
        return answer.strip().upper()

    def _line(self) -> str:
        """The next line, without its end."""
        while b"\r" not in self._rest:
            left_s = self._end - time.monotonic()
            if len(self._rest) > MOST_BYTES:
                raise _rubbish(self._rest.decode("latin-1"))
            try:
                if left_s <= 0.0:
                    raise TimeoutError
                self._socket.settimeout(left_s)
                data = self._socket.recv(MOST_BYTES)
            except OSError as fault:
                raise UserError(f"does not answer ({_reason(fault)})") from fault
            if not data:
                raise UserError("has ended the connection")
            self._rest += data
        line, _, self._rest = self._rest.partition(b"\r")
        self._rest = self._rest.removeprefix(b"\n")
        return line.decode("latin-1").strip()


def lamps_of(text: str) -> tuple[tuple[int, bool], ...]:
    """Read hours and state of each lamp, such as ``1234 1 567 0``."""
    if (
        not re.fullmatch(r"\d{1,6} [01]( \d{1,6} [01])*", text)
        or len(text.split()) > 2 * MOST_LAMPS
    ):
        raise _rubbish(text)
    words = text.split()
    return tuple(
        (int(hours), lit == "1") for hours, lit in zip(words[::2], words[1::2], strict=True)
    )


def errors_of(text: str) -> tuple[tuple[str, str], ...]:
    """Read the six digits of the error status: the parts with a warning or an error."""
    if not re.fullmatch(f"[012]{{{len(PARTS)}}}", text):
        raise _rubbish(text)
    return tuple(
        (part, SEVERITY[digit]) for part, digit in zip(PARTS, text, strict=True) if digit != "0"
    )


def read_password(file: Path) -> str:
    """Read the password of a projector; a UserError if others may read the file."""
    text = read_text(file, 4096).strip()
    refuse_shared(file)
    if not (1 <= len(text) <= 32 and text.isascii() and text.isprintable()):
        raise UserError("expected a password of 1 to 32 letters and digits", file=file)
    return text


def _accepted(answer: str) -> str:
    """The answer; a UserError for one of the errors of the specification."""
    if answer in ERRORS:
        raise UserError(ERRORS[answer])
    return answer


def _rubbish(text: str) -> UserError:
    return UserError(f"answers with something else than PJLink: {printable(text[:40])!r}")


def _reason(fault: OSError) -> str:
    return "too slow" if isinstance(fault, TimeoutError) else fault.strerror or str(fault)
