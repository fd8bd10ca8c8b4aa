"""Line numbers of the keys in a TOML file, for error messages.

TOML parsers do not report them. The text must be valid TOML; it is not checked here.
"""

import re
import tomllib
from typing import Any

Place = tuple[str | int, ...]  # keys of tables, and numbers in lists from 0

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
# A multi-line string may end in five quotes: its own last two, then the delimiter.
_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"""(?:"{0,2})' r"|'''.*?'''(?:'{0,2})"
    r'|"(?:\\.|[^"\\])*"' r"|'[^']*'",
    re.DOTALL,
)  # fmt: skip
_KEY = re.compile(r'(?:[^"\'=\]\n]|"(?:\\.|[^"\\])*"|\'[^\']*\')+')
_PLAIN = re.compile(r"[^,\]}#\n]*")  # numbers, dates, true and false
_STEP = re.compile(r"[^.\[\]]+")


def key_lines(text: str) -> dict[Place, int]:
    """The line, from 1, of every table, key and list entry in a TOML text.

    The line of a list of tables is that of its first table; the line of a table is that of its
    first mention.
    """
    return _Reader(text).lines


def line_of(lines: dict[Place, int], place: Place) -> int | None:
    """The line of a key or of the table that would contain it; None if that is the file.

    A list entry that does not exist has no line.
    """
    while place and place not in lines:
        if isinstance(place[-1], int):
            return None
        place = place[:-1]
    return lines.get(place)


def place_of(words: str) -> Place:
    """Parse a key such as ``fish[0].kind``."""
    return tuple(int(step) if is_count(step) else step for step in _STEP.findall(words))


def is_count(step: str) -> bool:
    """True if a word is the index of a list entry, of at most nine digits."""
    return step.isdecimal() and len(step) < 10


def words_of(place: Place) -> str:
    """Format a key such as ``fish[0].kind``."""
    steps = [f"[{step}]" if isinstance(step, int) else f".{step}" for step in place]
    return "".join(steps).removeprefix(".")


class _Reader:
    """A single pass through a text."""

    def __init__(self, text: str) -> None:
        self.lines: dict[Place, int] = {}
        self._text, self._at = text, 0
        self._line, self._counted = 1, 0  # the line number at this offset
        table: Place = ()
        listed: dict[Place, int] = {}  # number of tables so far in each list
        while self._skip():
            if text[self._at] != "[":
                self._pair(table)
                continue
            of_list = text.startswith("[[", self._at)
            self._at += 1 + of_list
            line, table = self._here(), ()
            *above, name = self._key()
            for step in above:
                table = self._note((*table, step), line)
                if table in listed:
                    table = self._note((*table, listed[table] - 1), line)
            table = self._note((*table, name), line)
            if of_list:
                listed[table] = listed.get(table, 0) + 1
                table = self._note((*table, listed[table] - 1), line)
            self._at += 1 + of_list

    def _skip(self) -> bool:
        """Skip blanks and comments; return whether any text is left."""
        self._take(_BLANK)
        return self._at < len(self._text)

    def _take(self, pattern: re.Pattern[str]) -> str:
        """Consume and return what the pattern matches here."""
        found = pattern.match(self._text, self._at)
        self._at = found.end() if found else len(self._text)
        return found[0] if found else ""

    def _here(self) -> int:
        self._line += self._text.count("\n", self._counted, self._at)
        self._counted = self._at
        return self._line

    def _note(self, place: Place, line: int) -> Place:
        self.lines.setdefault(place, line)
        return place

    def _key(self) -> list[str]:
        """The parts of a key such as ``water."light depth"``."""
        table: Any = tomllib.loads(f"{self._take(_KEY)} = 0")
        parts = []
        while table != 0:
            ((part, table),) = table.items()
            parts.append(part)
        return parts

    def _pair(self, table: Place) -> None:
        """A key and its value."""
        line = self._here()
        for part in self._key():
            table = self._note((*table, part), line)
        self._at += 1
        self._skip()
        self._value(table)

    def _value(self, place: Place) -> None:
        opening = self._text[self._at : self._at + 1]
        if opening in ("'", '"'):
            self._take(_STRING)
        elif opening not in ("[", "{"):
            self._take(_PLAIN)
        else:
            self._at += 1
            number = 0
            while self._skip() and self._text[self._at] not in "]}":
                if self._text[self._at] == ",":
                    self._at += 1
                elif opening == "{":
                    self._pair(place)
                else:
                    self._value(self._note((*place, number), self._here()))
                    number += 1
            self._at += 1
