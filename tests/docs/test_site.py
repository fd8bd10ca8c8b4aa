"""The documentation builds as a site, with no page left out and no link broken."""

import logging
import re
from pathlib import Path

import pytest
from mkdocs.commands.build import build
from mkdocs.config import load_config

from subsea.media import record as records
from subsea.repertoire import schema

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    told = []
    handler = logging.Handler(logging.WARNING)
    handler.emit = lambda record: told.append(record.getMessage())
    log = logging.getLogger("mkdocs")
    log.addHandler(handler)
    build(load_config(str(ROOT / "mkdocs.yml"), site_dir=str(folder), strict=False))
    log.removeHandler(handler)
    return folder, told


def test_no_link_is_broken_and_no_page_left_out(site):
    assert site[1] == []


def test_the_site_has_every_page(site):
    pages = {path.stem for path in (ROOT / "docs").rglob("*.md")}
    assert pages <= {path.parent.name for path in site[0].rglob("index.html")}
    assert "make run" in (site[0] / "index.html").read_text()
    assert (site[0] / "contributing" / "index.html").exists()


def test_the_site_holds_no_programs(site):
    assert not [path for path in site[0].rglob("*") if path.suffix in (".py", ".pyc")]


def test_the_site_loads_nothing_from_other_hosts(site):
    for page in site[0].rglob("*.html"):
        foreign = re.findall(
            r'(?:src|href)="(https?://[^"]+\.(?:js|css|woff2?|png))"', page.read_text()
        )
        assert foreign == [], page


def test_the_reference_is_up_to_date(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs")
    import make_reference

    for name in make_reference.MADE:
        made = make_reference.page(name)
        assert (ROOT / "docs" / name).read_text() == made, "run python docs/make_reference.py"


def test_pages_name_the_current_file_versions():
    page = (ROOT / "docs" / "reference" / "files.md").read_text()
    for module in (records, schema):
        assert f"`{module.FORMAT}` version {module.VERSION} " in page


def test_every_file_named_in_a_page_exists():
    named = re.compile(r"`((?:assets|capture|docs|subsea|tests|tools)/[\w./-]+)`")
    missing = {
        (page.name, name)
        for page in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
        for name in named.findall(page.read_text(encoding="utf-8"))
        if "NAME" not in name
        and not (ROOT / name).exists()
        and not re.fullmatch(r"subsea/\w+-v\d+", name)  # an environment
    }
    assert missing == set()


def test_shown_pictures_exist_and_all_pictures_are_shown():
    shown = set()
    for page in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]:
        shown |= set(re.findall(r"pictures/([\w-]+\.\w+)", page.read_text()))
    there = {path.name for path in (ROOT / "docs" / "pictures").iterdir()}
    assert shown == there
