"""The logbook: entries, its file, its page, and damaged files."""

import errno
from datetime import date

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.base.files import replacing
from subsea.cli.main import main
from subsea.dive import logbook
from subsea.dive.logbook import (
    LEAST_CUT,
    ROOM,
    Logbook,
    framed,
    logbook_folder,
    page_of,
    subjects,
    write_page,
)

PIXELS = np.full((90, 160, 3), 120, np.uint8)


def filled(folder):
    book = Logbook(folder)
    assert book.note("Moon wrasse", "A peaceful bay", PIXELS)
    assert book.note("cleaning", "A peaceful bay", PIXELS)
    return book


def test_a_subject_is_new_once_and_counted_once_a_visit(tmp_path):
    book = filled(tmp_path)
    assert not book.note("cleaning", "A peaceful bay", PIXELS)
    assert book.visit == {"Moon wrasse": True, "cleaning": True}
    again = Logbook(tmp_path)
    assert again.read() == ""
    assert again.entries == book.entries and again.entries["cleaning"].day == date.today()
    assert not again.note("cleaning", "Elsewhere") and again.visit == {"cleaning": False}
    assert again.entries["cleaning"].visits == 2
    assert again.entries["cleaning"].place == "A peaceful bay"
    assert again.picture("cleaning").is_file()


def test_a_visitor_s_logbook_in_an_exhibition_leaves_nothing():
    book = Logbook(None)
    assert book.note("mill", "A school", PIXELS) and book.picture("mill") is None
    book.forget_visit()
    assert not book.entries and not book.visit


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"[]", b'{"entries": {"mill": {"day": "soon", "place": ""}}}', b"\xff" * 40,
     b'{"entries": {"mill": {"day": "2026-01-01", "place": "", "picture": "../../x"}}}'],
)  # fmt: skip
def test_a_damaged_file_is_set_aside_and_said_in_one_line(tmp_path, content):
    (tmp_path / "logbook.json").write_bytes(content)
    book = Logbook(tmp_path)
    line = book.read()
    assert "damaged" in line and "\n" not in line and str(tmp_path / "logbook.json") in line
    assert (tmp_path / "logbook-damaged.json").read_bytes() == content
    assert book.note("mill", "A school", PIXELS)
    assert Logbook(tmp_path).read() == ""


def test_a_second_damaged_file_does_not_replace_the_first(tmp_path):
    for content in (b"{", b"]"):
        (tmp_path / "logbook.json").write_bytes(content)
        Logbook(tmp_path).read()
    assert (tmp_path / "logbook-damaged.json").read_bytes() == b"{"
    assert (tmp_path / "logbook-damaged-2.json").read_bytes() == b"]"


def test_a_full_disk_keeps_what_was_there(tmp_path, monkeypatch):
    book = filled(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def full(path, mode=0o666):
        raise UserError(f"cannot write ({errno.errorcode[errno.ENOSPC]})", file=path)

    with monkeypatch.context() as patch:
        patch.setattr(logbook, "replacing", full)
        with pytest.raises(UserError, match="cannot write"):
            book.note("mill", "A school", PIXELS)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    assert "mill" in book.entries  # until the end of the dive
    assert logbook.replacing is replacing


def test_a_page_has_what_was_seen_and_hints_for_the_rest(tmp_path):
    book = filled(tmp_path)
    page = page_of(book)
    assert page.count('<img alt="" src="data:image/jpeg;base64,') == 2
    assert "<b>A cleaning station</b><br>A peaceful bay" in page
    species, behaviors = subjects(book.entries)
    assert page.count('<div class="not">') == len(species) + len(behaviors) - 2
    assert "http" not in page and "<script" not in page
    visit = page_of(book, {"cleaning": True})
    assert "Moon wrasse" not in visit and "A cleaning station" in visit


def test_a_picture_is_cut_around_its_fish_and_inside():
    pixels = np.zeros((180, 320, 3), np.uint8)
    pixels[100, 200] = 255
    for x, y, size in ((200.5 / 320, 100.5 / 180, 0.1), (0.0, 1.0, 0.3), (0.5, 0.5, 1.0)):
        cut = framed(pixels, x, y, size)
        assert cut.shape[1] / cut.shape[0] == pytest.approx(16 / 9, abs=0.02)
        assert cut.shape[0] == round(180 * min(max(ROOM * size, LEAST_CUT), 1.0))
    near = framed(pixels, 200.5 / 320, 100.5 / 180, 0.1)
    (row,), (column,) = np.nonzero(near[..., 0])
    assert abs(row - near.shape[0] / 2) <= 1 and abs(column - near.shape[1] / 2) <= 1


def test_names_are_escaped_in_a_page():
    book = Logbook(None)
    book.note("<b>Fish</b>", "<script>alert(1)</script>")
    page = page_of(book)
    assert "<script" not in page and "<b>Fish" not in page
    assert "<b>&lt;b&gt;Fish&lt;/b&gt;</b>" in page


def test_pages_do_not_replace_each_other(tmp_path):
    book = filled(tmp_path / "book")
    first, second = write_page(book, tmp_path), write_page(book, tmp_path, book.visit)
    third = write_page(book, tmp_path)
    assert len({first, second, third}) == 3
    assert first.read_text(encoding="utf-8") == third.read_text(encoding="utf-8")


def test_the_command_prints_and_writes_it(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert main(["logbook"]) == 0
    assert "Moon wrasse                 not yet" in capsys.readouterr().out
    filled(logbook_folder())
    assert main(["logbook"]) == 0
    assert f"A cleaning station          {date.today()}  A peaceful bay" in capsys.readouterr().out
    assert main(["logbook", "--out", str(tmp_path / "book.html")]) == 0
    assert (tmp_path / "book.html").read_text(encoding="utf-8").count("<img") == 2
