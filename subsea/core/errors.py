"""Errors that are meant for the person at the keyboard."""

from difflib import get_close_matches

MOST_LETTERS = 1000  # of an error: a word that it quotes may be as long as its file


class UserError(Exception):
    """Something the user can mend, said in one line: which file, which key, what was expected."""

    def __init__(self, words: str) -> None:
        """Take the words as a terminal may show them, whatever they quote."""
        whole = len(words) <= MOST_LETTERS
        super().__init__(printable(words if whole else f"{words[:MOST_LETTERS]} …"))


def printable(text: str) -> str:
    """A text of unknown origin as a terminal may show it: without control characters."""
    return "".join(c if c.isprintable() else "?" for c in text)


def nearest(word: str, choices: list[str]) -> str:
    """A hint such as ``; did you mean 'fusilier'?``, or nothing if no choice is near."""
    match = get_close_matches(word, choices, n=1, cutoff=0.55)
    return f"; did you mean {match[0]!r}?" if match else ""


def unknown(kind: str, word: str, choices: list[str]) -> UserError:
    """The error for a name that is not among the choices, with the nearest one named."""
    hint = nearest(word, choices) or f"; there are: {', '.join(choices)}"
    return UserError(f"unknown {kind} {word!r}{hint}")
