"""Languages of visitors: their choice, their catalogues, and letters for all of them."""

import ast
import re
from functools import cache
from itertools import chain

import pytest
from babel.messages.mofile import read_mo
from babel.messages.pofile import read_po
from fontTools.ttLib import TTFont
from PIL import ImageFont

from subsea.base.language import (
    AUTO,
    LANGUAGES,
    VARIABLES,
    _catalogue,
    font_of,
    japanese_font,
    language,
    latin_font,
    marked,
    next_language,
    set_language,
    translated,
)
from subsea.base.syntax import parse_source
from subsea.base.system import ROOT
from tools import translate
from tools.translate import po_file

collected = cache(translate.collected)  # reads all of the code
OTHERS = [code for code in LANGUAGES if code != "en"]


@pytest.fixture(autouse=True)
def english():
    yield
    set_language("en")


def catalogue(code):
    with po_file(code).open("rb") as file:
        return {one.id: one.string for one in read_po(file) if one.id}


@pytest.mark.parametrize(
    ("variables", "code"),
    [
        ({}, "en"),
        ({"LANG": "de_AT.UTF-8"}, "de"),
        ({"LANG": "de_AT.UTF-8", "LC_ALL": "fr_CA"}, "fr"),
        ({"LANG": "C.UTF-8", "LANGUAGE": "pt_BR:es:de"}, "es"),
        ({"LANG": "ja_JP.eucJP@x"}, "ja"),
        ({"LANG": "C"}, "en"),
        ({"LANG": "tlh_KX"}, "en"),
    ],
)
def test_the_environment_chooses_if_the_settings_do_not(monkeypatch, variables, code):
    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    set_language(AUTO)
    assert language() == code


def test_languages_follow_one_another():
    seen = []
    for _ in LANGUAGES:
        set_language(next_language())
        seen.append(language())
    assert sorted(seen) == sorted(LANGUAGES) and seen[-1] == "en"


def test_words_without_a_translation_stay(monkeypatch, tmp_path):
    set_language("de")
    assert translated("Back") == "Zurück" and translated("Xyzzy") == "Xyzzy" == marked("Xyzzy")
    assert translated("") == ""  # not the header of the catalogue
    assert translated("Back", "fr") == "Retour"
    monkeypatch.setattr("subsea.base.language.resource_path", lambda name: tmp_path / name)
    _catalogue.cache_clear()
    assert translated("Back") == "Back"
    _catalogue.cache_clear()


def test_catalogues_have_the_words_of_the_code_and_no_others():
    """`python tools/translate.py` brings them up to date."""
    expected = {one.id for one in collected() if one.id}
    assert len(expected) > 200
    for code in OTHERS:
        assert set(catalogue(code)) == expected, code


@pytest.mark.parametrize("code", OTHERS)
def test_a_catalogue_is_complete_and_compiled(code):
    found = catalogue(code)
    for words, other in found.items():
        assert other, words
        fields = re.compile(r"\{\w+\}")
        assert sorted(fields.findall(words)) == sorted(fields.findall(other)), words
        assert words.endswith(".") == other.endswith((".", "。")), words
    with po_file(code).with_suffix(".mo").open("rb") as file:
        assert {one.id: one.string for one in read_mo(file) if one.id} == found
    assert "no native speaker has reviewed it" in po_file(code).read_text()


def test_fonts_have_every_letter():
    letters = {latin_font(): set(), japanese_font(): set()}
    for words in chain(LANGUAGES.values(), *(catalogue(code).values() for code in OTHERS)):
        kanji = re.search("[ぁ-んァ-ヶ一-龠]", words)
        assert font_of(words) == (japanese_font() if kanji else latin_font())
        letters[font_of(words)] |= set(words)
    for path, wanted in letters.items():
        font = ImageFont.truetype(str(path), 40)
        missing = bytes(font.getmask("\U000f0000"))  # of no font
        for letter in wanted - {" ", "\N{NO-BREAK SPACE}", "\N{IDEOGRAPHIC SPACE}"}:
            assert bytes(font.getmask(letter)) != missing, (path.name, letter)


def test_captions_may_have_any_japanese_letter():
    letters = translate.japanese_letters()
    assert len(letters) == 6879 and {"鯨", "鰯", "ヴ", "々"} <= letters
    with TTFont(japanese_font()) as font:
        missing = (letters | {*"àß…’Àñ—–“”€"}) - {*map(chr, font.getBestCmap())}
    assert missing == {"≒"}  # which Noto Sans CJK has not


def test_no_word_in_the_code_is_missed():
    """The collector does not see words in the braces of an f-string."""
    known = {one.id for one in collected()}
    for path in sorted((ROOT / "subsea").rglob("*.py")):
        text = path.read_text("utf-8")
        if not re.search(r"\b(translated|marked)\(", text):
            continue  # it takes a while to look at each node
        for node in ast.walk(parse_source(text)):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") in (
                "translated",
                "marked",
            ):
                word = node.args[0]
                assert not isinstance(word, ast.Constant) or word.value in known, (path, word.value)
