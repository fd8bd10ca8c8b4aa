"""Places of panels on a screen of 1280x720, and their memory over dives."""

from itertools import combinations

import pytest

from subsea.ui.inspector import (
    ABREAST,
    BAR,
    MARGIN,
    SIZES,
    TITLE,
    arrange,
    best_place,
    common,
    eye_areas,
    places_path,
    read_places,
    write_places,
)
from subsea.ui.panels import PANELS

SCREEN = 1280.0, 720.0
LINE = SCREEN[0] / ABREAST
ROOM = (
    MARGIN * LINE,
    BAR * LINE,
    SCREEN[0] - 2 * MARGIN * LINE,
    SCREEN[1] - (BAR + MARGIN) * LINE,
)


def opened(names):
    """The areas of panels that were opened one after the other."""
    areas = {}
    for name in names:
        wide, high = SIZES[name]
        taken = [*areas.values(), *(eye_areas(*SCREEN) if name == "Fish view" else ())]
        areas[name] = best_place((wide * LINE, high * LINE), ROOM, taken, LINE)
    return areas


@pytest.mark.parametrize("number", [2, 3])
def test_panels_do_not_overlap_where_there_is_room(number):
    for names in combinations(PANELS, number):
        if number == 3 and "Initialisation" in names:  # as wide as half the screen
            continue
        for one, other in combinations(opened(names).values(), 2):
            assert common(one, other) == 0.0, names


def test_all_panels_lie_on_the_screen_and_no_title_is_hidden():
    areas = opened(PANELS)
    for k, (name, (x, y, wide, high)) in enumerate(areas.items()):
        assert x >= 0 and y > 0 and x + wide <= SCREEN[0] and y + high <= SCREEN[1]
        for other in list(areas)[k + 1 :]:
            title = x, y, wide, TITLE * LINE
            assert common(areas[other], title) < 0.7 * wide * TITLE * LINE, (name, other)


def room_of(width, height):
    """The room for panels on a screen, and the height of letters."""
    line = width / ABREAST
    return (
        MARGIN * line,
        BAR * line,
        width - 2 * MARGIN * line,
        height - (BAR + MARGIN) * line,
    ), line


def test_panels_part_again_after_the_window_was_small():
    """They were pushed over one another, and stayed there."""
    names = ["Placement", "Physics", "Time"]
    areas = {}
    for width, height in ((1280.0, 720.0), (400.0, 300.0), (1280.0, 720.0)):
        room, line = room_of(width, height)
        areas |= arrange(names, areas, {}, room, line)
    for one, other in combinations(areas.values(), 2):
        assert common(one, other) == 0.0


def test_panels_keep_off_what_they_are_about_and_off_dragged_ones():
    box = 20.0, 60.0, 200.0, 150.0  # a stone where the panel would open
    (area,) = arrange(["Placement"], {}, {}, ROOM, LINE, [box]).values()
    assert common(area, box) == 0.0
    (before,) = arrange(["Placement"], {}, {}, ROOM, LINE).values()
    assert common(before, box) > 0.0
    areas = arrange(["Placement", "Time"], {}, {"Time": (0.02, 0.2)}, ROOM, LINE)
    assert areas["Time"][0] == pytest.approx(0.02 * SCREEN[0])
    assert areas["Time"][1] == pytest.approx(0.2 * SCREEN[1])
    assert common(areas["Placement"], areas["Time"]) == 0.0


def test_the_fish_view_covers_no_eye():
    assert not any(common(opened(["Fish view"])["Fish view"], eye) for eye in eye_areas(*SCREEN))


@pytest.mark.parametrize(
    "damaged",
    [b"", b"{", b"\xff\xfe", b"[]", b'{"Time": [0.5]}', b'{"Time": [2.0, 0.1]}', b"[" * 70_000],
)
def test_places_are_remembered_and_a_damaged_file_is_ignored(damaged, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "new"))
    assert read_places() == {}
    write_places({"Time": (0.25, 0.5)})
    assert read_places() == {"Time": (0.25, 0.5)}
    places_path().write_bytes(damaged)
    assert read_places() == {}
    places_path().unlink()
    places_path().mkdir()
    assert read_places() == {}
    write_places({"Time": (0.0, 0.0)})  # nothing happens
