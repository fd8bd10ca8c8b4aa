"""Errors that the user can fix, shown as one line without a stack trace."""

import errno
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path

MAX_CHARACTERS = 1000  # of a line, which may quote a word as long as its file


class UserError(Exception):
    """An error that the user can fix; `str` gives one line such as ``reef.toml:12: message``.

    Handlers read these fields instead of parsing the line:

    - `message`: what is wrong and what was expected, without the location.
    - `file`: the faulty file (or its description, such as "the scenario"), None if unknown.
    - `line`: the line in `file`, from 1; None if no single line is faulty.
    - `key`: the faulty key in `file`, such as ``fish[0].kind``. Not shown unless in `message`.
    - `changes`: settings of the command line (``--set``) that were applied on top of `file`.
    """

    def __init__(
        self,
        message: str,
        *,
        file: Path | str | None = None,
        line: int | None = None,
        key: str | None = None,
        changes: Sequence[str] = (),
    ) -> None:
        """Compose the line, printable on any terminal; a long one is cut."""
        self.message, self.file, self.line, self.key = message, file, line, key
        self.changes = tuple(changes)
        text = message
        if file is not None:
            place = f"{file}" if line is None else f"{file}:{line}"
            text = f"{' --set '.join([place, *changes])}: {message}"
        short = text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]} …"
        super().__init__(printable(short))


class TransientError(UserError):
    """An error that may pass by itself, such as a missing display: a service tries again."""


def is_full_disk(fault: BaseException | None) -> bool:
    """True if an error, or one that caused it, is that of a full disk or quota."""
    while fault and getattr(fault, "errno", None) not in (errno.ENOSPC, errno.EDQUOT):
        fault = fault.__cause__
    return fault is not None


def unreadable(path: Path, fault: OSError | ValueError) -> UserError:
    """The error for a file that cannot be opened or read."""
    if isinstance(fault, FileNotFoundError):
        return UserError("no such file", file=path)
    if isinstance(fault, IsADirectoryError):
        return UserError("cannot read (it is a folder)", file=path)
    reason = getattr(fault, "strerror", None) or str(fault).partition("\n")[0]
    return UserError(f"cannot read ({reason})", file=path)


def printable(text: str) -> str:
    """Make any text safe for a terminal.

    Control characters become "?". Bytes of a file name that are not UTF-8 become an escape such as
    ``\\udcff``.
    """
    known = text.encode("utf-8", "backslashreplace").decode("utf-8")
    return "".join(c if c.isprintable() else "?" for c in known)


def nearest(word: str, choices: list[str]) -> str:
    """A hint such as ``; did you mean 'fusilier'?``, or nothing if no choice is near."""
    match = get_close_matches(word, choices, n=1, cutoff=0.55)
    return f"; did you mean {match[0]!r}?" if match else ""


def unknown(kind: str, word: str, choices: list[str], key: str | None = None) -> UserError:
    """The error for a name that is not among the choices, with the nearest choice."""
    hint = nearest(word, choices) or f"; there are: {', '.join(choices)}"
    return UserError(f"unknown {kind} {word!r}{hint}", key=key)
