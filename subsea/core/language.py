"""The language of all words that a visitor sees: menu, help, instruments, notes and captions.

The words in the code are English and are the keys of GNU gettext's catalogues in
``assets/locale``, which `tools/translate.py` makes. Words for operators and makers (the terminal,
panels, errors) stay English.
"""

import gettext
import os
import re
from typing import TypeVar

from subsea.core.resources import resource_path

LANGUAGES = {"en": "English", "de": "Deutsch", "es": "Español", "fr": "Français", "ja": "日本語"}
"""Their own names, by the codes of ISO 639."""
AUTO = "auto"  # as the environment asks
VARIABLES = ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")  # of the environment, first the strongest

Words = TypeVar("Words", bound=str)

_current = "en"
_catalogue: gettext.NullTranslations = gettext.NullTranslations()


def translated(words: str) -> str:
    """The words in the current language; the words themselves where its catalogue lacks them."""
    return _catalogue.gettext(words) if words else ""


def marked(words: Words) -> Words:
    """The words as they are: marks constants for the catalogues; `translated` comes later."""
    return words


def language() -> str:
    """The code of the current language."""
    return _current


def set_language(code: str) -> None:
    """Choose one of LANGUAGES, or AUTO. Without its catalogue words stay English."""
    global _current, _catalogue
    _current = usual_language() if code == AUTO else code
    folder = str(resource_path("assets/locale"))
    _catalogue = gettext.translation("subsea", folder, [_current], fallback=True)


def next_language() -> str:
    """The code of the language after the current one, cyclically."""
    codes = list(LANGUAGES)
    return codes[(codes.index(_current) + 1) % len(codes)]


def usual_language() -> str:
    """The first of LANGUAGES that the environment asks for; English if it asks for others."""
    asked = next((value for name in VARIABLES if (value := os.environ.get(name))), "")
    for one in asked.split(":"):
        code = re.split(r"[_.@-]", one)[0].lower()
        if code in LANGUAGES:
            return code
    return "en"
