"""Text as other programs save it: byte-order marks, line ends, Latin-1 and continued lines."""

import codecs
import json
from datetime import date

import numpy as np
import pytest

from capture.learning.improve import write_plans
from subsea.base.errors import UserError
from subsea.base.file_kinds import MESH, check_result, csv_file, toml_file
from subsea.base.files import logical_lines, read_text, text_of
from subsea.base.findings import check_page, write_page
from subsea.base.language import set_language
from subsea.base.toml_files import load_toml
from subsea.dive.settings import DEFAULTS, read_settings, settings_path, usual_settings
from subsea.export.obj import read_mesh
from subsea.fish.color_sheet import assign_sheet
from subsea.fish.species import Species, load_species, species_file
from subsea.lab.benchmark_reports import read_reports
from subsea.scenario.load import load_scenario, scenario_file
from subsea.scenario.save import save_scenario
from subsea.scenario.schema import Scenario
from subsea.stage.show_file import load_show
from subsea.stage.show_player import DiveCount
from subsea.studio.draft import changed_on_disk, read_draft, save_draft, with_value
from subsea.ui.inspector import places_path, read_places
from subsea.ui.preferences import Preferences

MARKS = {
    "utf-8": codecs.BOM_UTF8,
    "utf-16-le": codecs.BOM_UTF16_LE,
    "utf-16-be": codecs.BOM_UTF16_BE,
}
REPORT = dict.fromkeys(["version", "renderer", "display", "scenario"], "x") | {
    "fish": 1, "frame_ms": {"p50": 1.0}, "stages_ms": {}, "size": [], "without": [], "seed": 1,
    "frames": 1,
}  # fmt: skip


@pytest.fixture(params=MARKS)
def written(request, tmp_path):
    """A function that writes a text as an editor of Windows does, and returns the path."""

    def write(name, text, path=None):
        path = path or tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(MARKS[request.param] + text.replace("\n", "\r\n").encode(request.param))
        return path

    return write


def test_tables_are_read_with_a_mark_and_edited_without(written, tmp_path):
    source = scenario_file("peaceful")
    path = written("reef.toml", read_text(source))
    reef, *_ = load_scenario(str(path))
    assert reef == load_scenario("peaceful")[0]
    save_scenario(reef, tmp_path / "copy.toml", like=path)
    assert read_text(tmp_path / "copy.toml") == read_text(source).replace("\n", "\r\n")
    assert toml_file("a scenario", "bounds").fits(path)
    with pytest.raises(UserError, match=r"bad\.toml:2: not valid TOML"):
        load_toml(written("bad.toml", "a = 1\nb ="), Scenario)
    show = written("show.toml", '[[item]]\nscenario = "peaceful"\n')
    assert len(load_show(show).item) == 1


def test_species_are_edited_without_their_mark(written, tmp_path):
    text = read_text(species_file("fusilier"))
    path, fusilier = written("fusilier.toml", text), load_species("fusilier")
    draft = read_draft(path)
    assert not changed_on_disk(path, draft)
    save_draft(with_value(draft, ("name",), "Another"), path)
    assert load_toml(path, Species).name == "Another"
    write_plans(written("fusilier.toml", text), path, swim=fusilier.swim, turn=fusilier.turn)
    assert load_toml(path, Species).swim == fusilier.swim
    assign_sheet(written("fusilier.toml", text), np.zeros((640, 1024, 4), "u1"))
    assert load_toml(path, Species).skin.sheet == "fusilier.png"


def test_settings_are_kept_with_a_mark(written, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    told = []
    path = written("", "# mine\n[mouse]\nsteer = false\n", settings_path())
    assert not usual_settings(told.append).mouse.steer and not told
    preferences = Preferences(read_settings(path), path, lambda settings: None)
    preferences.set_language("de")
    set_language("en")  # of this process
    preferences.save()
    assert read_text(path).startswith("# mine\r\n") and read_settings(path).display.language == "de"
    written("", '{"tour": [0.1, 0.2]}', places_path())
    assert read_places() == {"tour": (0.1, 0.2)}


def test_settings_in_another_encoding_are_left_where_they_are(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    told = []
    settings_path().parent.mkdir()
    settings_path().write_bytes("[mouse]\n# für Gäste\n".encode("latin-1"))
    assert usual_settings(told.append) == DEFAULTS
    fault = "cannot read (not UTF-8 text); save it as UTF-8; the defaults are used"
    assert told == [f"{settings_path()}:2: {fault}"]
    assert settings_path().exists()


def test_reports_and_tables_are_read_with_a_mark(written, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    assert read_reports(written("report.json", json.dumps(REPORT)))[0].fish == 1
    told = []
    written("", "date,dives\n2026-11-26,3\n", tmp_path / "subsea/dives.csv")
    assert DiveCount(told.append).of(date(2026, 11, 26)) == 3 and not told
    page = written("page.md", "# Page\n<!-- made by subsea x -->\n<!-- end of subsea x -->\n")
    check_page(page, "subsea x")
    write_page(page, "subsea x", ["new"])
    assert read_text(page).startswith("# Page")


def test_meshes_keep_all_vertices_and_faces(written, tmp_path):
    text = "v 0 0 1 \\\n 0.5 0.5 0.5\nv 1 0 0\nv 0 1 \\\n\\\n0\ncurv x\nf 1//1 \\\n2//1 3//1\n"
    path = written("fish.obj", text)
    lines, vertices = read_mesh(path)
    assert vertices.tolist() == [[0, 0, 1], [1, 0, 0], [0, 1, 0]]
    assert [line.split() for line in lines if line[:1] == "f"] == [["f", "1//1", "2//1", "3//1"]]
    with pytest.raises(UserError, match="line 3: expected `v x y z`"):
        read_mesh(written("faulty.obj", "v 0 \\\n0 0\nv 0\n"))
    check_result(path, MESH)


def test_meshes_may_have_comments_and_names_in_latin_1(tmp_path):
    path = tmp_path / "fish.obj"
    path.write_bytes("# Forêt \x85 C:\\\nv 0 0 0\no é\nv 1 0 0\n".encode("latin-1"))
    assert len(read_mesh(path)[1]) == 2
    check_result(path, MESH)


def test_a_table_of_a_spreadsheet_is_a_table(tmp_path):
    path = tmp_path / "table.csv"
    path.write_bytes(codecs.BOM_UTF8 + b"fish,frame\r\n1,2\r\n")
    check_result(path, csv_file("a table", "fish", "frame"))


def test_text_that_is_not_utf_8_has_a_line():
    with pytest.raises(UserError, match=r"^a\.txt:3: cannot read \(not UTF-8 text\)"):
        text_of(b"a\nb\n\xe9", "a.txt")
    with pytest.raises(UserError, match="not UTF-8 text"):
        text_of(codecs.BOM_UTF16_LE + b"a", "a.txt", foreign=True)
    assert text_of(b"\xe9", "a.txt", foreign=True) == "é"
    assert list(logical_lines("a\\\rb\r\n# c\\\nd\\")) == [(1, "a b"), (3, "# c\\"), (4, "d ")]
