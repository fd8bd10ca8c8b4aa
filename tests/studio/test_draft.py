"""Edited species files: every saved file loads and equals the shown draft."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.base.toml_files import load_toml
from subsea.fish.color_sheet import assign_sheet, read, write
from subsea.fish.species import Species, load_species, species_file, species_names
from subsea.fish.swimmer import Swimmer
from subsea.repertoire.findings import Severity
from subsea.studio.checks import static_checks
from subsea.studio.draft import (
    EditError,
    copy_draft,
    read_draft,
    save_draft,
    to_toml,
    with_sheet_path,
    with_value,
)
from subsea.studio.handles import FINS, PAIRED_FINS, drag_handle, handles
from subsea.studio.outline import add_point, remove_point, with_fin, with_length, with_mass
from tests.support.daily import examples

NAMES = species_names()


def drawn(name):
    return read_draft(species_file(name))


@pytest.fixture(scope="module")
def clownfish():
    return drawn("clownfish")


def test_a_file_whose_body_is_unstable_is_opened_and_mended(tmp_path):
    """Commands refuse it; only the builder can mend it."""
    path = tmp_path / "stiff.toml"
    text = species_file("fusilier").read_text(encoding="utf-8")
    path.write_text(text.replace("muscle_stiffness = 98.6", "muscle_stiffness = 2580.0"))
    with pytest.raises(UserError, match="too light for the stiffness"):
        load_species(str(path))
    draft = read_draft(path)
    (fault,) = (one for one in static_checks(draft.species) if one.severity == Severity.FAULT)
    assert fault.text.startswith("Unstable:") and "softer" in fault.text
    swimmer = Swimmer(draft.species)
    for _ in range(20):
        assert np.isfinite(swimmer.advance(0.1)).all()
    softer = with_value(draft, ("body", "muscle_stiffness"), 1500.0)  # not enough
    save_draft(softer, path)
    assert read_draft(path).species == softer.species
    mended = with_value(softer, ("body", "muscle_stiffness"), 98.6)
    assert mended.species == load_species("fusilier")
    save_draft(mended, path)
    assert load_species(str(path)) == mended.species
    with pytest.raises(EditError, match="too light"):  # no edit makes a sound body unstable
        with_value(mended, ("body", "muscle_stiffness"), 2580.0)


def test_ends_of_lines_stay_as_they_were(tmp_path, clownfish):
    path = tmp_path / "fish.toml"
    text = to_toml(with_value(clownfish, ("name",), "Before"))
    path.write_bytes(text.replace("\n", "\r\n").encode())
    save_draft(with_value(read_draft(path), ("name",), "After"), path)
    assert path.read_bytes() == text.replace("\n", "\r\n").replace("Before", "After").encode()


@pytest.mark.parametrize("name", NAMES)
def test_files_round_trip_and_handles_lie_on_surface_and_scaffold(name):
    draft = drawn(name)
    assert to_toml(draft) == species_file(name).read_text(encoding="utf-8")
    for view in ("side", "top"):
        for spot in handles(draft, view):
            assert -0.01 <= spot.at[0] <= 1.01 and abs(spot.at[1]) <= 1.0
            assert drag_handle(draft, view, spot.path, spot.at).species == draft.species


EDITS = st.lists(
    st.tuples(
        st.sampled_from(["move", "move", "move", "add", "remove", "fin", "weight", "length"]),
        st.sampled_from(["side", "top"]),
        st.integers(0, 200),
        st.tuples(st.floats(-0.3, 1.3), st.floats(-0.5, 0.5)),
    ),
    max_size=12,
)


def done(draft, kind, view, number, to):
    """The draft after some edit, which may be refused."""
    spots = handles(draft, view)
    spot = spots[number % len(spots)]
    try:
        if kind == "move":
            return drag_handle(draft, view, spot.path, to, soft=number % 2 == 0)
        if kind == "add":
            return add_point(draft, view, to)[0]
        if kind == "remove":
            return remove_point(draft, spot.path)
        if kind == "fin":
            fin = (*FINS, *PAIRED_FINS)[number % 4]
            return with_fin(draft, fin, number % 8 < 4)
        if kind == "weight" and draft.species.body:
            return with_mass(draft, 5.0 + number)
        if kind == "length" and draft.species.body:
            return with_length(draft, 5.0 + number % 40)
    except EditError as why:
        assert str(why)
    return draft


@given(name=st.sampled_from(NAMES), edits=EDITS)
@settings(max_examples=examples(12))
def test_any_edited_draft_can_be_saved_and_loaded(tmp_path_factory, name, edits):
    draft = first = drawn(name)
    for edit in edits:
        draft = done(draft, *edit)
    path = tmp_path_factory.mktemp("drafts") / "fish.toml"
    save_draft(draft, path)
    assert load_toml(path, Species) == draft.species
    assert tomllib.loads(path.read_text(encoding="utf-8")) == draft.content
    kept = [line for line in first.text.splitlines() if line.startswith("#")]
    for line in kept:  # its comments, in their order
        assert line in path.read_text(encoding="utf-8")


def test_one_moved_point_changes_one_line(clownfish):
    after = drag_handle(clownfish, "top", ("surface", "width", 4), (0.29, 0.09))
    old, new = (to_toml(one).splitlines() for one in (clownfish, after))
    assert [k for k, (a, b) in enumerate(zip(old, new, strict=True)) if a != b] == [
        next(k for k, line in enumerate(old) if line.startswith("width = [["))
    ]
    assert after.species.surface.width[4] == (0.29, 0.09)


def test_a_fin_goes_along_with_the_ridge_that_it_stands_on(clownfish):
    before = clownfish.species.surface
    after = drag_handle(clownfish, "side", ("surface", "back", 7), (0.42, 0.228)).species.surface
    rise = np.array(after.dorsal.edge) - before.dorsal.edge
    at = [x for x, _ in before.dorsal.edge].index(0.4)
    assert rise[at] == pytest.approx([0.0, 0.04], abs=0.005) and rise[-1] == pytest.approx([0, 0])
    assert after.ventral == before.ventral


def test_softly_the_points_beside_go_along_and_the_line_stays_smooth(clownfish):
    before = clownfish.species.surface.back
    place = (before[7][0], before[7][1] + 0.05)
    after = drag_handle(clownfish, "side", ("surface", "back", 7), place, soft=True)
    rise = np.array(after.species.surface.back)[:, 1] - np.array(before)[:, 1]
    assert rise[7] == pytest.approx(0.05) and 0.01 < rise[6] < 0.05 and 0.01 < rise[8] < 0.05
    assert abs(rise[0]) < 0.001 and abs(rise[-1]) < 0.001
    # In one step or in many: a hand drags.
    many = clownfish
    for share in np.linspace(0.1, 1.0, 10):
        step = (place[0], before[7][1] + 0.05 * share)
        many = drag_handle(many, "side", ("surface", "back", 7), step, soft=True)
    np.testing.assert_allclose(many.species.surface.back, after.species.surface.back, atol=0.001)


def test_a_moved_ring_is_the_same_ring_in_both_views_and_keeps_its_comment(clownfish):
    ring = ("body", "ring", 2)
    wider = drag_handle(clownfish, "top", ring, (0.57, -0.05))  # its twin, on the other side
    body = wider.species.body
    assert body.half_widths[2] == pytest.approx(0.05 * 18) and body.stations[3] == 0.57 * 18
    assert body.half_heights == clownfish.species.body.half_heights
    tall = drag_handle(wider, "side", ring, (0.57, 0.1)).species.body
    assert tall.half_heights[2] == pytest.approx(0.1 * 18) and tall.half_widths == body.half_widths
    assert "# cm, of the five rings" in to_toml(wider)


def test_points_keep_between_their_neighbours_and_back_above_belly(clownfish):
    far = drag_handle(clownfish, "side", ("surface", "back", 4), (0.9, -0.4))
    back = far.species.surface.back
    assert back[3][0] < back[4][0] < back[5][0] and back[4][1] > 0
    ring = drag_handle(clownfish, "side", ("body", "ring", 1), (0.99, 0.08)).species.body
    assert list(ring.stations) == sorted(ring.stations)
    tail = drag_handle(clownfish, "side", ("surface", "tail", "begin"), (0.05, 0.0))
    assert tail.species.surface.tail.begin == pytest.approx(0.3, abs=0.01)  # as far as may be


def test_a_point_is_added_on_the_nearest_line_and_taken_away_again(clownfish):
    more, path = add_point(clownfish, "side", (0.36, 0.2))
    assert path[:2] == ("surface", "back") and len(more.species.surface.back) == 18
    assert remove_point(more, path).species == clownfish.species
    with pytest.raises(EditError, match="already"):
        add_point(more, "side", tuple(more.species.surface.back[path[2]]))
    fin, path = add_point(clownfish, "side", (0.44, 0.26))
    assert path[:3] == ("surface", "dorsal", "edge")
    assert len(fin.species.surface.dorsal.edge) == 1 + len(clownfish.species.surface.dorsal.edge)
    with pytest.raises(EditError, match="five rings"):
        remove_point(clownfish, ("body", "ring", 0))


def test_a_line_keeps_the_fewest_points_that_make_it(clownfish):
    draft = clownfish
    with pytest.raises(EditError, match="at least"):
        for _ in range(30):
            draft = remove_point(draft, ("surface", "width", 1))
    assert len(draft.species.surface.width) == 3


def test_a_fin_taken_away_and_a_new_one(clownfish):
    bare = with_fin(clownfish, "dorsal", False)
    assert bare.species.surface.dorsal is None
    assert "dorsal = {" not in to_toml(bare)
    finned = with_fin(bare, "dorsal", True)
    assert finned.species.surface.dorsal and "dorsal = {" in to_toml(finned)


def test_a_species_from_another_under_its_own_name(clownfish, tmp_path):
    new = copy_draft(clownfish, "red_snapper", "Red snapper")
    save_draft(new, tmp_path / "red_snapper.toml")
    assert load_toml(tmp_path / "red_snapper.toml", Species).name == "Red snapper"
    for key, name in (("fusilier", "Red"), ("", "Red"), ("red/fish", "Red"), ("red", " ")):
        with pytest.raises(EditError):
            copy_draft(clownfish, key, name)


def test_a_copy_has_its_own_sheet(clownfish, tmp_path):
    path = tmp_path / "jewel.toml"
    save_draft(copy_draft(clownfish, "jewel", "Jewel"), path)
    sheet = np.full((640, 1024, 4), 200, np.uint8)
    assign_sheet(path, sheet)
    source = read_draft(path)
    assert Path(with_sheet_path(source).skin.sheet) == tmp_path / "jewel.png"
    copy = copy_draft(source, "gem", "Gem")
    (tmp_path / "own").mkdir()
    save_draft(copy, tmp_path / "own" / "gem.toml")
    np.testing.assert_array_equal(read(tmp_path / "own" / "gem.png"), sheet)
    assert load_toml(tmp_path / "own" / "gem.toml", Species).skin.sheet == "gem.png"
    write(tmp_path / "own" / "gem.png", sheet // 2)  # with a new picture meanwhile
    save_draft(with_value(copy, ("name",), "Ruby"), tmp_path / "own" / "gem.toml")
    np.testing.assert_array_equal(read(tmp_path / "own" / "gem.png"), sheet // 2)
    bare = with_value(copy, ("skin", "sheet"), None)
    assert with_sheet_path(bare).skin.sheet is None


def test_invalid_values_are_refused_with_the_reason(clownfish):
    with pytest.raises(EditError, match="masses"):
        with_mass(clownfish, 1e5)
    with pytest.raises(EditError, match="size_cm"):
        with_value(clownfish, ("size_cm",), [20.0, 10.0])


def test_a_folder_that_cannot_be_written_is_one_line(clownfish, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="file"):
        save_draft(clownfish, tmp_path / "file" / "fish.toml")
