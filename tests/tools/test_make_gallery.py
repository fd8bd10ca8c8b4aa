"""The gallery: models, pictures, a page that links to them, and runs that go on."""

import importlib.util
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

from subsea.base.errors import UserError
from subsea.export.clips import make_clips
from tests.support.gltf_reader import Reader

TOOL = Path(__file__).parents[2] / "tools" / "make_gallery.py"


@pytest.fixture(scope="module")
def tool():
    spec = importlib.util.spec_from_file_location("make_gallery", TOOL)
    tool = importlib.util.module_from_spec(spec)
    path = list(sys.path)
    spec.loader.exec_module(tool)
    sys.path[:] = path
    return tool


@pytest.fixture(scope="module")
def short(tool):
    """Species with two clips, which take a second to fit."""
    with pytest.MonkeyPatch.context() as patch:

        def two(name, detail):
            model, clips = make_clips(name, detail)
            return model, clips[:2]

        patch.setattr(tool, "make_clips", two)
        yield tool


@pytest.fixture(scope="module")
def folder(short, tmp_path_factory):
    folder = tmp_path_factory.mktemp("gallery")
    assert short.build(folder, ["clownfish"], 3) == 1
    return folder


class Page(HTMLParser):
    """Links, pictures and headings of a page."""

    def __init__(self, text):
        super().__init__()
        self.links, self.pictures, self.tags = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.tags.append((tag, values))
        if tag == "a":
            self.links.append(values["href"])
        if tag == "img":
            self.pictures.append(values)


@pytest.mark.nightly
def test_the_page_shows_and_links_what_is_there(folder):
    """With words for those who see no pictures, and no programs of others."""
    text = (folder / "index.html").read_text(encoding="utf-8")
    page = Page(text)
    assert page.links == ["clownfish.glb", "clownfish.usdz", "LICENSE.txt"]
    assert all((folder / link).stat().st_size > 1000 for link in page.links)
    [picture] = page.pictures
    assert picture["alt"].startswith("Ocellaris clownfish: ") and picture["width"] == "800"
    assert ("html", {"lang": "en"}) in page.tags
    assert "script" not in [tag for tag, _ in page.tags]
    assert "MIT licence" in text and len(text) < 5000
    assert [tag for tag, _ in page.tags if tag in ("h1", "h2", "h3")] == ["h1", "h2", "h3", "h2"]


def test_models_hold_the_clips_and_the_licence(folder):
    from pxr import Usd

    reader = Reader(folder / "clownfish.glb")
    assert list(reader.animations) == ["swim_slow", "swim_medium"]
    assert "MIT licence" in reader.content["asset"]["copyright"]
    stage = Usd.Stage.Open(str(folder / "clownfish.usdz"))
    assert stage.GetDefaultPrim().GetName() == "clownfish"
    assert "MIT licence" in stage.GetRootLayer().customLayerData["copyright"]


def test_a_second_run_makes_only_what_is_missing(short, folder):
    made = {path: path.stat().st_mtime_ns for path in folder.glob("clownfish.*")}
    assert short.build(folder, ["clownfish"], 3) == 0
    assert made == {path: path.stat().st_mtime_ns for path in folder.glob("clownfish.*")}
    now = short.stamp(short.items(["clownfish"])[0], 3)
    assert short.is_current(folder, "clownfish", now)
    assert not short.is_current(folder, "clownfish", short.stamp(short.items(["clownfish"])[0], 2))
    assert not short.is_current(folder, "schooling", now)


def test_an_unknown_model_is_one_line(short):
    with pytest.raises(UserError, match="did you mean 'clownfish'"):
        short.items(["clownfih"])
    assert [item.name for item in short.items(["schooling"])] == ["schooling"]
