"""A dive in a headset: pictures of both eyes, controllers and the panel."""

import numpy as np
import pytest

from subsea.dive.settings import COMFORTS
from subsea.stage.headset import display as headset_display
from subsea.stage.headset.controllers import Hand
from subsea.stage.headset.display import gamepad_of
from subsea.stage.headset.head import Pose
from subsea.world import snapshot
from subsea.world.feeding import EVERY_S, PINCH
from tests.stage.headset.conftest import SIZE, diving
from tests.support.headset import NOT_TURNED, turned


@pytest.fixture(scope="module")
def dive(display, quiet):
    """One dive for all tests of this file."""
    with pytest.MonkeyPatch.context() as patch, diving(quiet, patch) as (running, headset):
        yield running, headset, snapshot.take(running.world)


@pytest.fixture
def worn(dive):
    """The dive at its beginning, with head and hands at rest."""
    running, headset, begun = dive
    headset.rest()
    running.menu.hide()
    running.preferences.set_comfort(COMFORTS["usual"])
    snapshot.restore(running.world, begun)
    running.timeline.paused = False
    running.ride_fish(None)
    running.picture.head.recentre()
    running.frame(0.0)
    running.picture.head._dark = 0.0  # it has faded in
    running.text.vignette.__init__(running.text.vignette.most)
    return running, headset


def test_each_frame_is_begun_and_ended_and_shows_the_sea_to_both_eyes(worn):
    running, headset = worn
    before = len(headset.calls)
    for _ in range(3):
        running.frame(0.05)
    assert headset.calls[before:] == ["poll", "begin", "end"] * 3
    left, right = headset.pictures()
    assert left.std() > 3.0 and right.std() > 3.0
    assert np.abs(left - right).mean() > 0.3  # two points of view
    window = running.window_set.picture()
    assert window.shape == (*SIZE[::-1], 3) and window.std() > 3.0


def test_a_turned_head_sees_something_else(worn):
    running, headset = worn
    running.frame(0.1)
    ahead = headset.pictures()
    headset.orientation = turned(60.0, (0.0, 1.0, 0.0))
    running.frame(0.0)
    assert np.abs(headset.pictures() - ahead).mean() > 2.0


@pytest.mark.nightly
def test_the_sticks_steer_like_those_of_a_gamepad(worn):
    running, headset = worn
    submarine = running.world.state.submarine
    heading = float(submarine.angles[0])
    headset.hands = (Hand(stick=(0.0, 1.0)), Hand())
    for _ in range(20):
        running.frame(0.1)
    assert np.linalg.norm(submarine.velocity) > 10.0
    headset.hands = (Hand(stick=(-1.0, 0.0)), Hand(stick=(0.0, 0.0), trigger=1.0))
    depth = float(submarine.position[2])
    for _ in range(20):
        running.frame(0.1)
    assert submarine.angles[0] - heading > 0.1 and submarine.position[2] > depth
    headset.hands = (Hand(stick=(0.0, 0.0)), Hand(primary=True))
    running.frame(0.1)
    assert running.pilot.stopping


@pytest.mark.nightly
@pytest.mark.parametrize(
    "hand",
    [
        pytest.param(Hand(stick=(0.0, 0.0), feed=True), marks=pytest.mark.nightly),
        Hand(feed=True),
        Hand(squeeze=1.0),
    ],
)
def test_the_right_hand_scatters_food_by_a_button_or_a_fist(worn, hand):
    running, headset = worn
    absent = running.world.state.sea.absent
    for _ in range(round(EVERY_S / 0.1) + 1):
        running.frame(0.1)
    assert absent.min() >= 0.0
    headset.hands = (Hand(stick=hand.stick), hand)
    running.frame(0.1)
    assert (absent < 0.0).sum() == PINCH
    headset.hands = (Hand(), Hand())
    running.frame(0.1)


@pytest.mark.parametrize(
    ("degrees", "axis", "sign"), [(20.0, (0.0, 1.0, 0.0), 1), (-20.0, (0.0, 1.0, 0.0), -1)]
)
def test_hands_without_sticks_point_where_to_go(worn, degrees, axis, sign):
    running, headset = worn
    submarine = running.world.state.submarine
    heading = float(submarine.angles[0])
    aim = Pose(np.zeros(3), turned(degrees, axis))
    headset.hands = (Hand(), Hand(aim=aim))
    running.frame(0.1)
    assert np.linalg.norm(submarine.velocity) < 1.0  # pointing alone does nothing
    headset.hands = (Hand(), Hand(aim=aim, trigger=1.0))
    for _ in range(15):
        running.frame(0.1)
    assert np.linalg.norm(submarine.velocity) > 10.0
    assert sign * (submarine.angles[0] - heading) > 0.1


def test_hands_without_sticks_point_up_to_rise():
    up = Hand(aim=Pose(np.zeros(3), turned(30.0, (1.0, 0.0, 0.0))), trigger=1.0)
    down = up._replace(aim=Pose(np.zeros(3), turned(-30.0, (1.0, 0.0, 0.0))))
    assert gamepad_of(Hand(), up).axes[4:] == pytest.approx([-1.0, 0.745], abs=0.01)
    assert gamepad_of(down, Hand()).axes[4:] == pytest.approx([0.745, -1.0], abs=0.01)
    assert gamepad_of(Hand(squeeze=1.0), Hand()).buttons[7] == 1


def test_the_menu_opens_on_the_panel_and_a_controller_points_at_it(worn):
    running, headset = worn
    running.frame(0.1)
    running.run_command("pause")
    running.frame(0.1)
    plain = headset.pictures()
    headset.hands = (Hand(menu=True), Hand())
    running.frame(0.1)
    headset.hands = (Hand(), Hand())
    for _ in range(8):
        running.frame(0.1)
    assert running.menu.open
    changed = np.abs(headset.pictures() - plain).mean(axis=3) > 12
    assert changed[0].mean() > 0.05  # the panel is large,
    assert changed[0][:8].mean() < 0.1  # but not all of the picture
    # Pointing ahead, a little down, is the middle of the panel.
    aim = Pose(np.array([0.0, -0.09, 0.0]), NOT_TURNED)
    headset.hands = (Hand(), Hand(aim=aim))
    running.frame(0.1)
    x, y = running.gui.pointer
    assert x == pytest.approx(0.5, abs=0.03) and 0.3 < y < 0.7
    headset.hands = (Hand(), Hand(aim=aim._replace(orientation=turned(-15.0, (0, 1, 0)))))
    running.frame(0.1)
    assert running.gui.pointer[0] > 0.7
    assert running.pilot.stopping  # the triggers do not steer meanwhile


def test_recentring_takes_the_head_as_the_pilot(worn):
    running, headset = worn
    headset.position = np.array([0.4, 1.6, -0.3])
    headset.orientation = turned(35.0, (0.0, 1.0, 0.0))
    running.run_command("recentre")
    running.frame(0.1)
    (left, right) = running.picture.views()
    middle = (left.eye + right.eye) / 2.0
    np.testing.assert_allclose(middle, running.picture.eye.eye, atol=1e-3)
    ahead = -left.view[2, :3]
    np.testing.assert_allclose(ahead[:2], running.picture.eye.forward[:2], atol=1e-3)


def test_a_session_that_pauses_draws_only_the_window(worn):
    running, headset = worn
    running.frame(0.1)
    headset.running = False
    before = len(headset.calls)
    running.frame(0.1)
    assert headset.calls[before:] == ["poll", "begin"]
    headset.running, headset.visible = True, False
    kept = headset.pictures()
    headset.orientation = turned(90.0, (0.0, 1.0, 0.0))
    running.frame(0.1)
    assert headset.calls[-1] == "end"
    np.testing.assert_array_equal(headset.pictures(), kept)


def test_in_a_turn_a_rim_darkens_both_pictures(worn, monkeypatch):
    running, headset = worn
    running.frame(0.1)
    running.text.vignette.amount = 0.0
    clear = headset.pictures()
    monkeypatch.setattr(running.text.vignette, "update", lambda *rest: None)
    running.text.vignette.amount = 1.0
    running.frame(0.0)
    darker = clear - headset.pictures()
    edge = darker[:, 50:70, :6].mean(), darker[:, 50:70, -6:].mean()
    assert max(edge) > 10.0 and darker[:, 60:68, 50:70].mean() < 2.0


def test_the_menu_has_presets_of_comfort(worn):
    running, _ = worn
    running.menu.show()
    running.menu.page = "Comfort"
    entries = {entry.text: entry for entry in running.menu.entries()}
    assert entries["Usual"].chosen and not entries["Calm"].chosen
    entries["Calm"].act()
    assert running.pilot.settings.comfort.snap_turn_deg == 30.0
    running.menu.hide()
    submarine = running.world.state.submarine
    submarine.angles[0] = submarine.previous_angles[0] = np.radians(100.0)
    running.frame(0.0)
    running.frame(0.0)
    forward = np.mean([-view.view[2, :3] for view in running.picture.views()], axis=0)
    assert np.degrees(np.arctan2(forward[1], forward[0])) == pytest.approx(90.0, abs=0.1)
    assert running.text.vignette.most == 0.9


def test_a_tilted_vessel_keeps_the_horizon_level(worn):
    running, _ = worn
    submarine = running.world.state.submarine
    submarine.angles[1] = submarine.previous_angles[1] = np.radians(20.0)
    running.frame(0.0)
    for view in running.picture.views():
        assert -view.view[2, 2] == pytest.approx(0.0, abs=1e-6)


def test_the_lamp_is_in_the_hand_and_ears_are_on_the_head(worn):
    running, headset = worn
    running.run_command("lights")
    headset.hands = (Hand(), Hand(aim=Pose(np.array([0.3, -0.3, -0.2]), NOT_TURNED)))
    headset.orientation = turned(90.0, (0.0, 1.0, 0.0))
    running.frame(0.1)
    running.frame(0.1)
    seat = running.picture.eye
    places, ways = running.picture.head.lamps(seat)
    right = np.cross(seat.forward, seat.up)
    np.testing.assert_allclose(places[0] - seat.eye, 30.0 * right - 30.0 * seat.up
                               + 20.0 * seat.forward, atol=1e-6)  # fmt: skip
    np.testing.assert_allclose(ways[0], seat.forward, atol=1e-6)
    assert running.picture.head.lamps(seat) is not None
    ears = running.sound.head(seat)
    np.testing.assert_allclose(ears.forward, -right, atol=1e-6)


def test_hands_feel_a_knock_and_a_shark_on_its_side(worn):
    running, headset = worn
    running.frame(0.1)
    submarine = running.world.state.submarine
    headset.calls.clear()
    running.picture.head.feel(running.world)
    assert headset.calls == []
    submarine.previous_position = submarine.position - np.array([6.0, 0.0, 0.0])
    submarine.velocity[:] = 0.0
    running.picture.head.feel(running.world)
    assert headset.calls == ["pulse 0", "pulse 1"]


def test_after_half_an_hour_it_recommends_a_break_once(worn, monkeypatch, capsys):
    running, _ = worn
    running.frame(0.1)
    monkeypatch.setattr(headset_display, "LONG_S", -1.0)
    running.frame(0.1)
    running.frame(0.1)
    assert capsys.readouterr().err.count("time for a break") == 1


def test_the_picture_fades_in(worn):
    running, headset = worn
    running.picture.head.recentre()
    running.frame(0.0)
    dark = headset.pictures().mean()
    running.picture.head._dark = 0.0
    running.frame(0.0)
    assert headset.pictures().mean() > 3.0 * dark
