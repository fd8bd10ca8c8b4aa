"""What the pages of the documentation tell to type: their blocks, their commands, their options."""

import re
from collections.abc import Iterator
from typing import NamedTuple

from subsea.core.resources import ROOT

PAGES = {
    path.name: path
    for path in [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *sorted((ROOT / "docs").glob("*.md")),
    ]
}
# What a line that is to be typed begins with; others that a page needs are added here.
PROGRAMS = re.compile(
    r"(?:subsea|subsea-capture|make|python|dask|systemctl|journalctl|pip|mkdir|cp|sed|\.) \S"
    r"|\.venv/bin/"
)
FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"`([^`]+)`")


class Block(NamedTuple):
    """A fenced block: its page, the line at which its text begins, its language, its text."""

    page: str
    line: int
    kind: str
    text: str


class Command(NamedTuple):
    """What is to be typed. In a sentence it may stand without what it cannot be typed without."""

    page: str
    line: int
    text: str
    inline: bool


def blocks(page: str) -> Iterator[Block]:
    """The fenced blocks of a page."""
    text = PAGES[page].read_text(encoding="utf-8")
    for found in FENCE.finditer(text):
        indent, kind, inside = found.groups()
        lines = [line.removeprefix(indent) for line in inside.splitlines(keepends=True)]
        yield Block(page, text[: found.start(3)].count("\n") + 1, kind, "".join(lines))


def prose(page: str) -> str:
    """A page without its blocks, line for line."""
    blank = lambda found: "\n" * found[0].count("\n")  # noqa: E731
    return FENCE.sub(blank, PAGES[page].read_text(encoding="utf-8"))


def inline(page: str) -> Iterator[tuple[int, str]]:
    """Line and text of all that stands between backticks in sentences."""
    text = prose(page)
    for found in INLINE.finditer(text):
        yield text[: found.start()].count("\n") + 1, " ".join(found[1].split())


def steps(page: str) -> list[Command | Block]:
    """What a reader of the page does: commands, and files to save, in their order."""
    found: list[Command | Block] = [
        Command(page, line, text, inline=True)
        for line, text in inline(page)
        if PROGRAMS.match(text)
    ]
    for block in blocks(page):
        if block.kind == "sh":
            found += [
                Command(page, block.line + k, line, inline=False)
                for k, line in enumerate(block.text.splitlines())
                if line.strip()
            ]
        elif block.kind in ("toml", "python", "text"):
            found.append(block)
    return sorted(found, key=lambda step: step.line)
