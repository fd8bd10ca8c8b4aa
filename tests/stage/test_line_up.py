"""Line-up on the wall in a dive: pictures move, undo returns them, keys and nodes take part."""

from contextlib import closing
from types import SimpleNamespace

import glfw
import msgspec
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.dive.options import DisplayOptions
from subsea.dive.part import DivePart
from subsea.stage.cluster.ticks import FollowerTicks
from subsea.stage.console import commands
from subsea.stage.line_up import TheatreLineUp, _line_up_command, key_command
from subsea.stage.parts import TheatrePart
from subsea.stage.setup import theatre_windows
from subsea.stage.theatre.line_up import LineUpState
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.theatre_file import Adjustment, Corners
from subsea.ui.dive import Dive
from subsea.view.structured_light import light_patterns, light_picture
from tests.support.windows import display_pixels, dive_options

SIZE = (200, 150)
THEATRE = """
# Two walls.
[[window]]
name = "left"
size = [200, 150]
position = [0, 0]
{node_left}

[[window]]
name = "right"
size = [200, 150]
position = [200, 0]
{node_right}

[[channel]]
name = "left"
window = "left"
cylinder = {{ radius_cm = 275, left_deg = -50, right_deg = 5, bottom_cm = -75, top_cm = 75 }}
blend = true

[[channel]]
name = "right"
window = "right"
cylinder = {{ radius_cm = 275, left_deg = -5, right_deg = 50, bottom_cm = -75, top_cm = 75 }}
blend = true
"""
CLUSTER = '[cluster]\nmaster = "a"\n'


def written(folder, nodes=False):
    path = folder / "hall.toml"
    left, right = ('node = "a"', 'node = "b"') if nodes else ("", "")
    path.write_text(THEATRE.format(node_left=left, node_right=right) + CLUSTER * nodes)
    return path


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return written(tmp_path_factory.mktemp("hall"))


@pytest.fixture(scope="module")
def hall(display, user, quiet, path):
    part = TheatrePart(str(path))
    with closing(Dive(dive_options(quiet, SIZE, "low", parts=[part]))) as running:
        user.glide(running, 0.2)
        yield running


@pytest.fixture
def tool(hall, user):
    """The line-up of the hall, with the grid on the wall; it is cancelled at the end."""
    line_up = hall.parts[0].line_up
    line_up.session._undo.clear()
    line_up.session._clock = iter(range(0, 10**6, 10)).__next__  # every change for itself
    line_up.apply(commands.EditLineUp(True))
    line_up.apply(commands.ShowLineUpPattern("grid", "full"))
    line_up.apply(commands.ChooseLineUp("left", "upper_left"))
    user.glide(hall, 0.2)
    yield line_up
    line_up.apply(commands.EditLineUp(False))
    user.glide(hall, 0.2)


def wall(hall, user):
    """The pictures of both windows (h, w, 3), after another frame."""
    user.glide(hall, 0.2)
    return [hall.picture.renderer.read_pixels(k).astype(int) for k in (0, 1)]


def test_a_moved_corner_moves_that_picture_and_undo_returns_the_same_bytes(hall, user, tool):
    before = wall(hall, user)
    tool.apply(commands.MoveLineUp(12, 9))
    after = wall(hall, user)
    np.testing.assert_array_equal(after[1], before[1])
    assert after[0][0, :3].max() <= 1  # the corner has gone from there
    assert np.abs(after[0] - before[0]).mean() > 2.0
    tool.apply(commands.CompareLineUp(True))
    for one, other in zip(wall(hall, user), before, strict=True):
        np.testing.assert_array_equal(one, other)
    tool.apply(commands.CompareLineUp(False))
    tool.apply(commands.UndoLineUp())
    for one, other in zip(wall(hall, user), before, strict=True):
        np.testing.assert_array_equal(one, other)
    tool.apply(commands.RedoLineUp())
    for one, other in zip(wall(hall, user), after, strict=True):
        np.testing.assert_array_equal(one, other)


class Blank(DivePart):
    """A show that is closed, and black over the sea."""

    def before(self, dive, elapsed_s):
        return True

    def over(self, presented):
        return msgspec.structs.replace(presented, blank=1.0)


def test_structured_light_lies_over_a_closed_show_and_hides_the_pointer(hall, user, monkeypatch):
    light = hall.parts[0].light
    monkeypatch.setattr(hall, "parts", [*hall.parts, Blank()])
    user.glide(hall, 0.2)
    assert hall.black

    def pointers():
        return {glfw.get_input_mode(one.handle, glfw.CURSOR) for one in hall.window_set.windows}

    assert pointers() == {glfw.CURSOR_NORMAL}
    patterns = light_patterns(SIZE)
    steps = (patterns.index(one) + 1 for one in patterns if one.name in ("grey-96", "columns-2"))
    for step in steps:
        light.show(step)
        user.glide(hall, 0.2)
        assert not hall.black and pointers() == {glfw.CURSOR_HIDDEN}
        shown = display_pixels()[: SIZE[1], : 2 * SIZE[0]]
        np.testing.assert_array_equal(shown[:, : SIZE[0]], light_picture(patterns[step - 1], SIZE))
        assert not shown[:, SIZE[0] :].any()
    light.show(0)
    user.glide(hall, 0.2)
    assert hall.black
    monkeypatch.undo()
    user.glide(hall, 0.2)
    assert pointers() == {glfw.CURSOR_NORMAL} and not hall.black


def test_all_points_move_the_picture_by_that_many_pixels(hall, user, tool):
    tool.apply(commands.ShowLineUpPattern("sea"))
    tool.apply(commands.ShowLineUpPattern("white", "full"))
    tool.apply(commands.SetLineUp("edge_mask", [[50, 0], [90, 0], [90, 150], [50, 150]]))
    stripe = wall(hall, user)[0][75, :, 1] > 128
    tool.apply(commands.SetLineUp("points_px", [[[20, 0]] * 3] * 3))
    np.testing.assert_array_equal(wall(hall, user)[0][75, :, 1] > 128, stripe)  # a mask stays
    tool.apply(commands.SetLineUp("edge_mask", None))
    lit = wall(hall, user)[0][75, :, 1] > 128
    assert not lit[:19].any() and lit[21:150].all()


def test_light_changes_both_masks_of_an_overlap(hall, user, tool):
    tool.apply(commands.ShowLineUpPattern("white", "full"))
    before = wall(hall, user)
    tool.apply(commands.SetLineUp("blend_width", 0.3))
    after = wall(hall, user)
    assert all(np.abs(after[k] - before[k])[75].max() > 9 for k in (0, 1))
    tool.apply(commands.SetLineUp("gain", [1.0, 0.2, 1.0]))
    red, green, _ = wall(hall, user)[0][75, 60]
    assert red > 250 and (green / 255) ** 2.2 == pytest.approx(0.2, abs=0.02)


def test_others_are_dim_or_black_and_the_chosen_one_is_marked(hall, user, tool):
    full = wall(hall, user)[1].mean()
    tool.apply(commands.ShowLineUpPattern(others="dim"))
    dim = wall(hall, user)[1].mean()
    tool.apply(commands.ShowLineUpPattern(others="black"))
    left, right = wall(hall, user)
    assert full > 2.0 * dim > 2.0 and right.max() <= 1
    assert (left[:12, :12] == 255).all(axis=2).any()  # the mark of the corner


@pytest.mark.parametrize("changes", [("flip", "horizontal"), ("rotate", 180), ("rotate", 90)])
def test_turns_are_live_and_come_back(hall, user, tool, changes):
    before = wall(hall, user)
    tool.apply(commands.SetLineUp(*changes))
    turned = wall(hall, user)
    assert np.abs(turned[0] - before[0]).mean() > 5.0
    np.testing.assert_array_equal(turned[1], before[1])
    tool.apply(commands.UndoLineUp())
    for one, other in zip(wall(hall, user), before, strict=True):
        np.testing.assert_array_equal(one, other)


def test_the_sea_returns_at_the_end_as_it_was(hall, user, tool):
    tool.apply(commands.MoveLineUp(12, 9))
    user.glide(hall, 0.2)
    assert hall.picture.pattern
    tool.apply(commands.EditLineUp(False))
    user.glide(hall, 0.2)
    assert not hall.picture.pattern
    assert all(patch.adjustment is None for patch in hall.picture.rig.patches)


def test_keys_of_a_window_line_up(hall, user, tool, monkeypatch):
    window = hall.window_set.windows[0]
    assert window.take_key(glfw.KEY_RIGHT, glfw.MOD_SHIFT)
    assert tool.session.state.adjustments["left"].corners_px == Corners(upper_left=(10, 0))
    assert window.take_key(glfw.KEY_Z, glfw.MOD_CONTROL)
    assert not tool.session.unsaved
    assert not window.take_key(glfw.KEY_H, 0)
    assert window.take_key(glfw.KEY_Z, glfw.MOD_CONTROL)  # nothing to undo: one line
    assert "nothing to undo" in hall.overlay.note_text
    assert window.take_key(glfw.KEY_T, glfw.MOD_CONTROL)
    assert not tool.session.state.open
    assert not window.take_key(glfw.KEY_RIGHT, 0)  # it steers again


@pytest.mark.parametrize(
    ("key", "modifiers", "command"),
    [
        (glfw.KEY_UP, 0, commands.MoveLineUp(0, -1)),
        (glfw.KEY_LEFT, glfw.MOD_ALT, commands.MoveLineUp(-0.1, 0)),
        (glfw.KEY_DOWN, glfw.MOD_CONTROL, None),
        (glfw.KEY_TAB, 0, commands.ChooseLineUp(point="next")),
        (glfw.KEY_TAB, glfw.MOD_SHIFT, commands.ChooseLineUp(point="previous")),
        (glfw.KEY_PAGE_DOWN, 0, commands.ChooseLineUp("next")),
        (glfw.KEY_Y, glfw.MOD_CONTROL, commands.RedoLineUp()),
        (glfw.KEY_S, glfw.MOD_CONTROL, commands.SaveLineUp()),
        (glfw.KEY_S, 0, None),
    ],
)
def test_keys_and_their_commands(key, modifiers, command):
    assert key_command(key, modifiers | glfw.MOD_NUM_LOCK, True) == command
    assert key_command(key, modifiers, False) is None


def test_a_node_may_ask_for_the_line_up_alone():
    move = commands.MoveLineUp(1.0, 0.5)
    assert _line_up_command(commands.to_json(move)) == move
    for wrong in (commands.to_json(commands.BlankScreens(True)), b"{", b"\xff"):
        with pytest.raises(UserError):
            _line_up_command(wrong)


class Shown:
    """A node that shows a line-up, without windows."""

    def __init__(self, path, node, ticks=None):
        part = TheatrePart(str(path), node=node)
        display = DisplayOptions()
        windows = theatre_windows(part, display)
        self.line_up = TheatreLineUp(part, windows, display)
        self.notes, self.view = [], windows.view
        self.dive = SimpleNamespace(
            tick_source=ticks, world=None, note=self.notes.append,
            picture=SimpleNamespace(rig=windows.installation.rig, fit=self.fit),
            overlay=SimpleNamespace(help_hidden=True),
        )  # fmt: skip
        self.marks = {}

    def fit(self, rig, canvas, marks, clear):
        self.dive.picture.rig, self.canvas, self.marks = rig, canvas, marks


class Told(FollowerTicks):
    """The ticks of a node that has heard a line-up."""

    def __init__(self):
        self.heard, self.reported, self.renewed = None, [], []

    @property
    def lined_up(self):
        return self.heard

    def report(self, words):
        self.reported.append(words)

    def renew_view(self, view):
        self.renewed.append(dict(view))


MOVED = Adjustment(
    corners_px=Corners(upper_left=(4, 2)), points_px=[[(1.0, 2.0)] * 3] * 3, blend_width=0.5
)
STATE = LineUpState({"right": MOVED}, open=True, channel="right", point="1,1", grid=(3, 3))


@pytest.fixture
def node(tmp_path):
    """The node `b` of the hall, with a theatre file of its own."""
    return Shown(written(tmp_path, nodes=True), "b", Told())


def test_nodes_show_the_same_bytes_as_one_computer_does(node, path):
    whole = Shown(path, None, SimpleNamespace())
    whole.line_up.session.state = STATE
    whole.line_up.ticked(whole.dive)
    node.dive.tick_source.heard = STATE
    node.line_up.ticked(node.dive)
    there, here = whole.dive.picture.rig.patches[1], node.dive.picture.rig.patches[0]
    assert here.mask.tobytes() == there.mask.tobytes()
    for one, other in zip(here.adjustment, there.adjustment, strict=True):
        np.testing.assert_array_equal(one, other)
    assert node.marks[0].tobytes() == whole.marks[1].tobytes()


def test_a_node_saves_its_own_file_once_as_the_master_does(node):
    path = node.line_up._shown.setup.path
    before = node.view["theatre files"]
    node.dive.tick_source.heard = msgspec.structs.replace(STATE, saved={"right": MOVED})
    node.line_up.ticked(node.dive)
    assert load_theatre(str(path))[0].channel[1].corners_px == MOVED.corners_px
    assert "# Two walls." in path.read_text() and path.with_name("hall.toml.bak").exists()
    assert node.view["theatre files"] != before
    assert node.dive.tick_source.renewed == [node.view] and not node.dive.tick_source.reported
    node.dive.tick_source.heard = msgspec.structs.replace(STATE, saved={"right": MOVED})
    node.line_up.ticked(node.dive)
    assert not path.with_name("hall.toml.bak2").exists()
    # The same view as that of a node that starts with the new file.
    assert Shown(path, "b", Told()).view == node.view


def test_a_node_that_cannot_save_says_so_once_and_goes_on(node):
    path = node.line_up._shown.setup.path
    path.write_text(path.read_text().replace("Two", "Three"))
    for _ in range(2):
        node.dive.tick_source.heard = msgspec.structs.replace(STATE, saved={"right": MOVED})
        node.line_up.ticked(node.dive)
    [line] = node.dive.tick_source.reported
    assert line == node.notes[0] and "has changed on disk" in line and len(node.notes) == 1
    assert node.dive.picture.rig.patches[0].adjustment is not None


def test_a_shrunk_theatre_is_saved_in_the_pixels_of_its_file(tmp_path):
    path = written(tmp_path)
    part = TheatrePart(str(path), shrink=2)
    display = DisplayOptions()
    line_up = TheatreLineUp(part, theatre_windows(part, display), display)
    line_up.apply(commands.EditLineUp(True))
    line_up.apply(commands.MoveLineUp(3.5, -2.0))
    line_up.apply(commands.SaveLineUp())
    assert load_theatre(str(path))[0].channel[0].corners_px == Corners(upper_left=(3.5, -2.0))
