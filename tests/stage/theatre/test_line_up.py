"""The line-up of a theatre: choosing, moving, undo, comparing, saving."""

import msgspec
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage.theatre.line_up import (
    CORNERS,
    NOTHING_CHANGED,
    LineUp,
    LineUpChannel,
    LineUpState,
    point_names,
    point_places,
)
from subsea.stage.theatre.line_up_marks import line_up_marks
from subsea.stage.theatre.theatre_file import Adjustment, Corners

SIZE = (400, 200)
OLD = Adjustment(gamma=2.4, corners_px=Corners(upper_left=(1.0, 2.0)))


class Clock:
    """A clock that is set by hand."""

    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def line_up(clock):
    made = LineUp(
        [LineUpChannel("left", SIZE, OLD, "a", True), LineUpChannel("right", SIZE)], clock
    )
    made.begin()
    return made


def test_nothing_is_shown_or_changed_before_it_begins():
    made = LineUp([LineUpChannel("left", SIZE)])
    assert made.state is NOTHING_CHANGED
    for act in (lambda: made.move(1, 0), lambda: made.choose("left"), made.undo,
                lambda: made.show("white"), lambda: made.compare(True)):  # fmt: skip
        with pytest.raises(UserError, match="begin the line-up first"):
            act()
    assert made.state is NOTHING_CHANGED
    assert not made.describe()["open"]


def test_it_begins_with_the_first_corner_of_the_first_channel(line_up):
    state = line_up.state
    assert (state.open, state.channel, state.point) == (True, "left", "upper_left")
    assert state.adjustments == {}


def test_points_and_channels_are_chosen_by_name_and_in_turn(line_up):
    line_up.choose("right", "2,3")
    assert (line_up.state.channel, line_up.state.point) == ("right", "2,3")
    line_up.choose(point="next")
    assert line_up.state.point == "2,4"
    line_up.choose("next")
    assert (line_up.state.channel, line_up.state.point) == ("left", "2,4")
    line_up.choose("previous", "upper_left")
    line_up.choose(point="previous")
    assert (line_up.state.channel, line_up.state.point) == ("right", "4,4")
    for wrong in (("middle", ""), ("left", "5,1"), ("left", "edge:1"), ("left", "")):
        if wrong == ("left", ""):
            continue
        with pytest.raises(UserError, match="unknown"):
            line_up.choose(*wrong)


def test_moves_add_up_on_what_the_file_has(line_up):
    line_up.move(0.1, 0.0)
    line_up.move(0.2, -10.0)
    assert line_up.state.adjustments["left"].corners_px.upper_left == (1.3, -8.0)
    assert line_up.state.adjustments["left"].gamma == 2.4
    line_up.choose("right", "2,3")
    line_up.move(5.0, 1.0)
    points = line_up.state.adjustments["right"].points_px
    assert points[1][2] == (5.0, 1.0) and np.count_nonzero(points) == 2
    assert (len(points[0]), len(points)) == (4, 4)


def test_undo_and_redo_return_equal_states(line_up, clock):
    states = [line_up.state.adjustments]
    for k, act in enumerate((lambda: line_up.move(3, 0), lambda: line_up.set("gamma", 2.0),
                             lambda: line_up.set("flip", "horizontal"))):  # fmt: skip
        clock.now = 10.0 * k
        act()
        states.append(line_up.state.adjustments)
    for wanted in states[-2::-1]:
        line_up.undo()
        shown = {name: one for name, one in line_up.state.adjustments.items() if one != OLD}
        assert shown == wanted
    with pytest.raises(UserError, match="nothing to undo"):
        line_up.undo()
    assert not line_up.unsaved
    for wanted in states[1:]:
        line_up.redo()
        assert line_up.state.adjustments == wanted
    with pytest.raises(UserError, match="nothing to do again"):
        line_up.redo()


def test_a_drag_is_undone_at_once_and_a_later_one_for_itself(line_up, clock):
    for k in range(20):
        clock.now = 0.1 * k
        line_up.move(1, 0)
    clock.now = 9.0
    line_up.move(1, 0)
    assert line_up.describe()["undo"] == 2
    line_up.undo()
    assert line_up.state.adjustments["left"].corners_px.upper_left == (21.0, 2.0)
    line_up.undo()
    assert line_up.state.adjustments["left"] == OLD


def test_a_new_change_ends_redo(line_up, clock):
    line_up.move(1, 0)
    line_up.undo()
    line_up.set("gamma", 2.0)
    with pytest.raises(UserError, match="nothing to do again"):
        line_up.redo()


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("gamma", 9.0, "0.5 to 4"),
        ("gamma", "bright", "expected"),
        ("edge_mask", [[0, 0]], "at least 3"),
        ("window", "left", "unknown key"),
        ("corners_px", {"upper_left": [500, 300], "lower_right": [-500, 0]}, "cross"),
        ("points_px", [[[0, 0], [0, 0]], [[900, 0], [-900, 0]]], "fold"),
        ("grid", [1, 99], "at least 2"),
    ],
)
def test_what_cannot_be_shown_is_refused_and_changes_nothing(line_up, key, value, said):
    before = line_up.state
    with pytest.raises(UserError, match=said):
        line_up.set(key, value)
    assert line_up.state == before
    assert line_up.describe()["undo"] == 0


def test_a_corner_cannot_be_dragged_over_another(line_up):
    line_up.move(100, 50)
    before = line_up.state
    with pytest.raises(UserError, match="cross"):
        line_up.move(600, 300)
    assert line_up.state == before


def test_before_shows_the_file_and_a_change_ends_it(line_up):
    line_up.move(5, 0)
    changed = line_up.state.adjustments
    line_up.compare(True)
    assert line_up.state.adjustments == {"left": OLD}
    line_up.compare(False)
    assert line_up.state.adjustments == changed
    line_up.compare(True)
    line_up.move(1, 0)
    assert line_up.state.adjustments["left"].corners_px.upper_left == (7.0, 2.0)


def test_another_grid_keeps_the_shape_of_the_field(line_up):
    line_up.choose(point="1,1")
    line_up.move(8.0, 0.0)
    line_up.set("grid", [7, 4])
    points = np.array(line_up.state.adjustments["left"].points_px)
    assert points.shape == (4, 7, 2)
    assert points[0, 0].tolist() == [8.0, 0.0] and 3.0 < points[0, 1, 0] < 5.0
    line_up.choose(point="4,7")
    line_up.set("grid", [3, 3])
    assert line_up.state.point == CORNERS[0] and line_up.state.grid == (3, 3)


def test_the_edge_mask_moves_by_its_corners(line_up):
    line_up.set("edge_mask", [[0, 0], [400, 0], [400, 200]])
    line_up.choose(point="edge:2")
    line_up.move(-5, 3)
    assert line_up.state.adjustments["left"].edge_mask[1] == (395.0, 3.0)
    line_up.set("edge_mask", None)
    assert line_up.state.point == CORNERS[0]
    assert line_up.state.adjustments["left"].edge_mask is None


def test_saving_hands_over_what_differs_once(line_up):
    written = []
    with pytest.raises(UserError, match="nothing has changed"):
        line_up.save(written.append)
    line_up.move(5, 0)
    changed = dict(line_up.state.adjustments)
    line_up.save(written.append)
    assert written == [changed]
    assert line_up.state.saved == changed and not line_up.unsaved
    with pytest.raises(UserError, match="nothing has changed"):
        line_up.save(written.append)
    line_up.undo()  # a saved change can be taken back ...
    line_up.save(written.append)  # ... and that be saved
    assert written[-1] == {"left": OLD}


def test_a_fault_while_saving_leaves_it_unsaved(line_up):
    def full(changes):
        raise UserError("no space is left", file="hall.toml")

    line_up.move(5, 0)
    with pytest.raises(UserError, match="no space"):
        line_up.save(full)
    assert line_up.unsaved and line_up.state.saved == {}


def test_cancel_returns_to_what_was_saved(line_up):
    line_up.move(5, 0)
    line_up.save(lambda changes: None)
    saved = line_up.state.adjustments
    line_up.set("gamma", 1.8)
    line_up.cancel()
    assert line_up.state.adjustments == saved and not line_up.state.open
    line_up.begin()
    line_up.undo()  # a cancelled change can be restored
    assert line_up.state.adjustments["left"].gamma == 1.8


def test_the_state_survives_its_way_over_the_wire(line_up):
    line_up.move(5, 0)
    line_up.set("grid", [17, 17])
    line_up.choose(point="9,9")
    line_up.move(1, 1)
    data = msgspec.msgpack.encode(line_up.state)
    assert msgspec.msgpack.decode(data, type=LineUpState) == line_up.state
    assert len(data) < 8000


def test_a_turned_picture_keeps_its_points_within(line_up):
    line_up.set("rotate", 90)
    about = line_up.describe()
    assert about["size"] == (200, 400)
    assert {one["name"] for one in about["points"]} == set(point_names(OLD, (4, 4)))


def test_places_of_points_are_those_on_the_wall():
    places = point_places(OLD, SIZE, (3, 3))
    assert places["upper_left"] == pytest.approx((1 / 400, 1.0 - 2 / 200))
    assert places["1,1"] == pytest.approx(places["upper_left"])
    assert places["lower_right"] == pytest.approx((1.0, 0.0))


def test_marks_show_the_grid_and_stand_at_the_chosen_point():
    marks = line_up_marks(OLD, SIZE, (4, 4), "upper_left")
    assert marks.shape[1] == 5 and len(marks) % 3 == 0
    white = marks[(marks[:, 2:] == 1.0).all(axis=1)]
    assert white[:, :2].mean(axis=0) == pytest.approx([1 / 400, 1.0 - 2 / 200], abs=1e-6)
    mirrored = line_up_marks(Adjustment(flip="horizontal"), SIZE, (4, 4), "upper_left")
    white = mirrored[(mirrored[:, 2:] == 1.0).all(axis=1)]
    assert white[:, :2].mean(axis=0) == pytest.approx([1.0, 1.0], abs=1e-6)
