"""Pages, messages, docstrings and comments avoid turns that are hard to read."""

import ast
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
SOURCES = [
    path
    for folder in ("subsea", "capture", "tools", "docs", "tests")
    for path in sorted((ROOT / folder).rglob("*.py"))
    if path != Path(__file__) and "node_modules" not in path.parts
]
TURNS = {
    name: re.compile(turn, re.MULTILINE)
    for name, turn in {
        "is told": r"\b(is|are|be|was|were) told\b",
        "who without a person": r"([.;:,]|\b(for|of|to|by|from|that)) [Ww]ho \w+|^Who \w+",
        "whoever": r"\b[Ww]ho(so)?ever\b",
        "that which": r"\bthat which\b",
        "of which": r"\bof which\b",
        "so many": r"\bso (many|much)\b(?! (as|that))",
        "anew": r"\b[Aa]new\b",
        "at hand": r"\bat hand\b",
        "the dice": r"\bthe dice\b",
        "is no …": r"(?<![Tt]here )\b(is|are|was|were) (no|none)\b(?! (longer|faster|more|less))",
        "makes no sense": r"\bmakes? no sense\b",
        "a sentence that begins with What, Whether or How": (
            r"(^|\. )(What|Whether|How) (?!to\b)[^?:\n]*\.(?!\w)"
        ),
    }.items()
}


def paragraphs(page: Path) -> Iterator[str]:
    """The paragraphs of a page, without code."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    text = re.sub(r"`[^`]*`", "CODE", text)
    for paragraph in re.split(r"\n\s*\n|\n(?=[-|#])", text):
        yield " ".join(paragraph.split())


# A ninth of the time of `tokenize`, which finds the same.
COMMENT_OR_TEXT = re.compile(
    r"""#[^\n]*|[rbfu]{0,2}(?:\"{3}(?:[^\\"]|\\.|"(?!""))*\"{3}|'{3}(?:[^\\']|\\.|'(?!''))*'{3}"""
    r"""|"(?:[^\\"\n]|\\.)*"|'(?:[^\\'\n]|\\.)*')""",
    re.IGNORECASE | re.DOTALL,
)


def sentences(source: Path) -> Iterator[str]:
    """The comments and texts of a module."""
    for text in COMMENT_OR_TEXT.findall(source.read_text(encoding="utf-8")):
        if text.startswith("#"):
            yield text.lstrip("# ")
        elif " " in text:
            with suppress(SyntaxError, ValueError):  # of an f-string
                text = ast.literal_eval(text)
            if isinstance(text, str):
                yield text


@pytest.mark.parametrize(("files", "texts"), [(PAGES, paragraphs), (SOURCES, sentences)])
def test_texts_avoid_turns_that_are_hard_to_read(files, texts):
    found = [
        f"{file.relative_to(ROOT)}: {name}: …{text[max(match.start() - 30, 0) : match.end() + 30]}…"
        for file in files
        for text in texts(file)
        for name, turn in TURNS.items()
        if (match := turn.search(text))
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    "text",
    [
        "The cause is told.", "Wait for who comes.", "Whoever dives sees it.", "It is made anew.",
        "A file that is no record.", "What is wrong is printed.", "How it works. Then more.",
        "Three files, of which one is new.", "The dice decide: the dice are fair.",
    ],
)  # fmt: skip
def test_each_turn_is_found(text):
    assert any(turn.search(text) for turn in TURNS.values())


@pytest.mark.parametrize(
    "text",
    [
        "There is no display.", "It is no longer there.", "How to dive", "What is a species?",
        "A visitor who leaves.", "How a fish decides",
    ],
)  # fmt: skip
def test_plain_sentences_pass(text):
    assert not [name for name, turn in TURNS.items() if turn.search(text)]
