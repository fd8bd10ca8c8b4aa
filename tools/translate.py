"""Bring the message catalogues of `assets/locale` up to date with the words in the code.

`python tools/translate.py` collects the words that visitors see, adds new ones to each catalogue,
drops old ones, and compiles the catalogues. `--font FILE` also makes the font of Japanese from
Noto Sans CJK. Words of species, scenarios and behaviors are data and are collected from there.
"""

import sys
from argparse import ArgumentParser
from datetime import UTC, datetime
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.extract import extract_from_file
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po, write_po

from subsea.base.files import replacing
from subsea.base.language import LANGUAGES
from subsea.base.system import ROOT, resource_names
from subsea.behavior.table import BEHAVIORS
from subsea.dive.options import RETINA_COLOURS
from subsea.dive.settings import CONTROLS, KEY_WORDS
from subsea.export.web import WORDS as EXPORTED_PAGE
from subsea.fish.species import load_species, shipped_species
from subsea.rendering.output.quality import CHOICES
from subsea.scenario.load import load_scenario
from subsea.stage.console.http import page_words, script_words
from subsea.stage.show_file import load_show, shipped_shows, show_path
from subsea.state.codes import MENTAL_STATES

FOLDER = ROOT / "assets/locale"
FONT = ROOT / "assets/fonts/NotoSansJP-subset.otf"
KEYWORDS = {"translated": None, "marked": None}
# Of Europe: basic, Latin-1, punctuation.
LATIN = "".join(map(chr, (*range(0x20, 0x7F), *range(0xA0, 0x100), *range(0x2010, 0x2060), 0x20AC)))
KANA = "".join(map(chr, (*range(0x3000, 0x3020), *range(0x3041, 0x3100), *range(0xFF01, 0xFF60))))
NO_DATE = datetime(2026, 1, 1, tzinfo=UTC)  # so that the files depend on their words only
HEADER = """\
# Words that visitors of subsea see, in {name}.
# A draft: no native speaker has reviewed it.
"""


def main(words: list[str] | None = None) -> int:
    """Update the catalogues; exit code 0."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--font", type=Path, help="a font file of Noto Sans CJK, to take from it")
    options = parser.parse_args(words)
    template = collected()
    for code in LANGUAGES:
        if code == "en":
            continue
        catalogue = updated(code, template)
        missing = [one.id for one in catalogue if one.id and not one.string]
        folder = po_file(code).parent
        folder.mkdir(parents=True, exist_ok=True)
        with replacing(po_file(code)) as part, part.open("wb") as file:
            write_po(file, catalogue, width=100, no_location=True, omit_header=False)
        with replacing(po_file(code).with_suffix(".mo")) as part, part.open("wb") as file:
            write_mo(file, catalogue)
        print(f"{code}: {len(template)} messages, {len(missing)} to translate")
        for one in missing:
            print(f"    {one!r}")
    if options.font:
        make_font(options.font)
    return 0


def po_file(code: str) -> Path:
    """The catalogue of a language, for translators."""
    return FOLDER / code / "LC_MESSAGES/subsea.po"


def collected() -> Catalog:
    """All words that visitors see, from the code and from data."""
    template = Catalog(project="subsea", charset="utf-8")
    for path in sorted((ROOT / "subsea").rglob("*.py")):
        if any(f"{name}(" in path.read_text("utf-8") for name in KEYWORDS):  # others take seconds
            for _, words, _, _ in extract_from_file("python", path, keywords=KEYWORDS):
                template.add(words)
    for words in data():
        template.add(words)
    return template


def data() -> list[str]:
    """The words of controls, behaviors, states, species, scenarios and shows."""
    scenarios = [load_scenario(name)[0] for name in resource_names("assets/scenarios", ".toml")]
    shows = [load_show(show_path(name)) for name in shipped_shows()]
    return [
        *(control.what for control in CONTROLS.values()),
        *KEY_WORDS,
        *(behavior.name for behavior in BEHAVIORS),
        *MENTAL_STATES,
        *RETINA_COLOURS,
        *CHOICES,
        *page_words(),
        *script_words(),
        *EXPORTED_PAGE.values(),
        *(load_species(name).name for name in shipped_species()),
        *(words for one in scenarios for words in (one.title, one.description)),
        *(cue.caption for one in scenarios for cue in one.direction if cue.caption),
        *(
            item.caption
            for one in shows
            for item in one.item
            if item.caption and isinstance(item.caption, str)
        ),
    ]


def updated(code: str, template: Catalog) -> Catalog:
    """The catalogue of a language with the messages of the template only, in their order."""
    known = Catalog()
    if po_file(code).exists():
        with po_file(code).open("rb") as file:
            known = read_po(file)
    catalogue = Catalog(
        locale=code,
        project="subsea",
        version="1",
        charset="utf-8",
        header_comment=HEADER.format(name=LANGUAGES[code]).rstrip(),
        last_translator="nobody yet",
        language_team="nobody yet",
        creation_date=NO_DATE,
        revision_date=NO_DATE,
        fuzzy=False,
    )
    for one in template:
        if one.id:
            before = known.get(one.id)
            catalogue.add(one.id, before.string if before else "")
    return catalogue


def make_font(source: Path) -> None:
    """Take the letters of Japanese and of the other languages from a font of Noto Sans CJK."""
    from fontTools.subset import Options, Subsetter
    from fontTools.ttLib import TTCollection, TTFont

    if source.suffix == ".ttc":
        fonts = TTCollection(str(source)).fonts
        font = next(one for one in fonts if one["name"].getDebugName(1) == "Noto Sans CJK JP")
    else:
        font = TTFont(str(source))
    letters = {*KANA, *LATIN, *japanese_letters()}
    for code in LANGUAGES:
        if code != "en":
            with po_file(code).open("rb") as file:
                letters |= {letter for one in read_po(file) for letter in str(one.string)}
    options = Options(layout_features=[], hinting=False, desubroutinize=False, name_IDs=["*"])
    subset = Subsetter(options)
    subset.populate(text="".join(sorted(letters)))
    subset.subset(font)
    FONT.parent.mkdir(parents=True, exist_ok=True)
    with replacing(FONT) as part:
        font.save(str(part))
    print(f"{FONT.relative_to(ROOT)}: {len(font.getGlyphOrder())} glyphs")


def japanese_letters() -> set[str]:
    """The 6,879 letters of JIS X 0208, which Japanese captions are written with."""
    codes = (bytes([0xA0 + row, 0xA0 + cell]) for row in range(1, 85) for cell in range(1, 95))
    return {letter for code in codes for letter in code.decode("euc_jp", errors="ignore")}


if __name__ == "__main__":
    sys.exit(main())
