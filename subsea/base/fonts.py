"""The fonts of text in windows and on pictures: files of TrueType or OpenType outlines."""

import importlib.util
import re
from pathlib import Path
from typing import Literal

from subsea.base.resources import resource_path

CJK = "\u2e80-\uffef"  # letters of Chinese and Japanese, as a range in a regular expression


def latin_font(weight: Literal["Regular", "Bold"] = "Regular") -> Path:
    """Roboto, which comes with the library of the panels."""
    found = importlib.util.find_spec("imgui_bundle")
    assert found is not None and found.origin is not None  # a dependency
    return Path(found.origin).parent / "assets" / "fonts" / "Roboto" / f"Roboto-{weight}.ttf"


def japanese_font() -> Path:
    """The letters of Noto Sans CJK that the Japanese catalogue needs, and all kana."""
    return resource_path("assets/fonts/NotoSansJP-subset.otf")


def font_of(words: str) -> Path:
    """The font that has the letters of some words."""
    return japanese_font() if re.search(f"[{CJK}]", words) else latin_font()
