"""Blocks, commands and options in the pages of the documentation."""

import re
from collections.abc import Iterator
from typing import NamedTuple

from subsea.base.system import ROOT

OF_ROOT = [ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
PAGES = {path.name: path for path in [*OF_ROOT, *sorted((ROOT / "docs").rglob("*.md"))]}
# Beginnings of lines to type; others that a page needs are added here.
PROGRAMS = re.compile(
    r"(?:subsea|subsea-capture|make|python|dask|systemctl|journalctl|pip|mkdir|cp|sed|\.) \S"
    r"|\.venv/bin/"
)
FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"`([^`]+)`")


class Block(NamedTuple):
    """A fenced block."""

    page: str
    line: int  # where its text begins
    kind: str  # its language
    text: str


class Command(NamedTuple):
    """A command of a page."""

    page: str
    line: int
    text: str
    inline: bool  # in a sentence, where required arguments may be missing


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
    """Line and text of inline code."""
    text = prose(page)
    for found in INLINE.finditer(text):
        yield text[: found.start()].count("\n") + 1, " ".join(found[1].split())


def steps(page: str) -> list[Command | Block]:
    """Commands to type and files to save, in the order of the page."""
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
