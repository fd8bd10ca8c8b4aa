"""The language of all words that a visitor sees: menu, help, instruments, notes and captions.

The words in the code are English and are the keys of GNU gettext's catalogues in
``assets/locale``, which `tools/translate.py` makes. Words for operators and makers (the terminal,
panels, errors) stay English. Also the files of fonts, for windows and pictures.
"""

import gettext
import importlib.util
import os
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Literal, TypeVar

from subsea.base.system import resource_path

LANGUAGES = {"en": "English", "de": "Deutsch", "es": "Español", "fr": "Français", "ja": "日本語"}
"""Their own names, by the codes of ISO 639."""
AUTO = "auto"  # as the environment asks
VARIABLES = ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")  # of the environment, first the strongest

Words = TypeVar("Words", bound=str)

_current = "en"


def translated(words: str, code: str = "") -> str:
    """The words in the language `code`, or in the current one; as they are without translation."""
    return _catalogue(code or _current).gettext(words) if words else ""


def marked(words: Words) -> Words:
    """The words as they are: marks constants for the catalogues; `translated` comes later."""
    return words


def language() -> str:
    """The code of the current language."""
    return _current


def set_language(code: str) -> None:
    """Choose one of LANGUAGES, or AUTO. Without its catalogue words stay English."""
    global _current
    _current = usual_language() if code == AUTO else code


def next_language() -> str:
    """The code of the language after the current one, cyclically."""
    codes = list(LANGUAGES)
    return codes[(codes.index(_current) + 1) % len(codes)]


def usual_language() -> str:
    """The first of LANGUAGES that the environment asks for; English if it asks for others."""
    asked = next((value for name in VARIABLES if (value := os.environ.get(name))), "")
    return first_known(asked.split(":"))


def first_known(tags: Iterable[str]) -> str:
    """The first of LANGUAGES among tags such as ``de_AT.UTF-8`` or ``de-AT``; else English."""
    codes = (re.split(r"[_.@;-]", tag)[0].strip().lower() for tag in tags)
    return next((code for code in codes if code in LANGUAGES), "en")


@cache
def _catalogue(code: str) -> gettext.NullTranslations:
    folder = str(resource_path("assets/locale"))
    return gettext.translation("subsea", folder, [code], fallback=True)


CJK = "\u2e80-\uffef"  # letters of Chinese and Japanese, as a range in a regular expression


def latin_font(weight: Literal["Regular", "Bold"] = "Regular") -> Path:
    """Roboto, which comes with the library of the panels."""
    found = importlib.util.find_spec("imgui_bundle")
    assert found is not None and found.origin is not None  # a dependency
    return Path(found.origin).parent / "assets" / "fonts" / "Roboto" / f"Roboto-{weight}.ttf"


def japanese_font() -> Path:
    """Noto Sans CJK with the letters of JIS X 0208, so that captions may have any of them."""
    return resource_path("assets/fonts/NotoSansJP-subset.otf")


def font_of(words: str) -> Path:
    """The font that has the letters of some words."""
    return japanese_font() if re.search(f"[{CJK}]", words) else latin_font()
