"""From input to helm, without a window."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.dive.pilot import DEAD_ZONE, Pilot
from subsea.dive.settings import ComfortSettings, MouseSettings, Settings

DT = 0.033


def settle(pilot, seconds=3.0):
    for _ in range(round(seconds / DT)):
        helm = pilot.helm(DT)
    return helm


def steering_at(x, y):
    pilot = Pilot()
    pilot.point(0.0, 0.5)
    pilot.point(x, y)
    return pilot


def test_nobody_at_the_helm_asks_for_nothing():
    assert settle(Pilot()) == (0.0, 0.0, 0.0, 0.0, False)


def test_a_pointer_that_enters_waits_until_it_moves_and_then_takes_over_gently():
    pilot = Pilot()
    pilot.point(0.9, 0.0)
    assert settle(pilot).yaw == 0.0
    pilot.point(0.95, 0.0)
    assert -0.1 < pilot.helm(DT).yaw <= 0.0
    assert settle(pilot).yaw < -0.8  # right of the middle turns right


@pytest.mark.parametrize(
    ("x", "y", "yaw", "pitch"),
    [
        (-0.8, 0.0, 1, 0),
        (0.8, 0.0, -1, 0),
        (0.0, 0.8, 0, 1),
        (0.0, -0.8, 0, -1),
        (0.05, 0.05, 0, 0),
    ],
)
def test_the_submarine_looks_where_the_pointer_is(x, y, yaw, pitch):
    helm = settle(steering_at(x, y))
    assert (math.copysign(1, helm.yaw) if abs(helm.yaw) > 1e-3 else 0) == yaw
    assert (math.copysign(1, helm.pitch) if abs(helm.pitch) > 1e-3 else 0) == pitch


def test_both_buttons_lift_with_the_pointer():
    pilot = steering_at(0.0, 0.9)
    pilot.hold("ahead", "mouse left")
    pilot.hold("astern", "mouse right")
    helm = settle(pilot)
    assert helm.heave > 0.5
    assert helm.pitch == pytest.approx(0.0, abs=1e-3)
    assert helm.surge == pytest.approx(0.0, abs=1e-3)
    pilot.release("mouse right")
    pilot.hold("astern", "S")  # a key and a button cancel out
    helm = settle(pilot)
    assert helm.heave == pytest.approx(0.0, abs=1e-3)
    assert helm.pitch > 0.3


def test_the_wheel_sets_a_lasting_speed():
    pilot = Pilot()
    pilot.wheel(4.0)
    assert settle(pilot).surge == pytest.approx(0.5, abs=1e-3)
    pilot.wheel(-100.0)
    assert settle(pilot).surge == pytest.approx(-1.0, abs=1e-3)


@pytest.mark.parametrize(
    ("action", "field", "sign"),
    [
        ("ahead", "surge", 1), ("astern", "surge", -1), ("left", "yaw", 1), ("right", "yaw", -1),
        ("up", "pitch", 1), ("down", "pitch", -1), ("rise", "heave", 1), ("dive", "heave", -1),
    ],
)  # fmt: skip
def test_every_manoeuvre_is_held_and_let_go(action, field, sign):
    pilot = Pilot()
    pilot.hold(action, "x")
    assert getattr(settle(pilot), field) == pytest.approx(sign, abs=1e-3)
    pilot.release("x")
    assert getattr(settle(pilot), field) == pytest.approx(0.0, abs=1e-3)


def test_a_stick_asks_for_a_part_and_the_strongest_input_counts():
    pilot = Pilot()
    pilot.hold("ahead", "pad left stick up", 0.4)
    assert settle(pilot).surge == pytest.approx(0.4, abs=1e-3)
    pilot.hold("ahead", "W")
    assert settle(pilot).surge == pytest.approx(1.0, abs=1e-3)
    pilot.release("W")
    assert settle(pilot).surge == pytest.approx(0.4, abs=1e-3)
    pilot.hold("ahead", "pad left stick up", 0.0)
    assert settle(pilot).surge == pytest.approx(0.0, abs=1e-3)


def test_two_keys_for_one_thing_are_both_to_be_let_go():
    pilot = Pilot()
    pilot.hold("left", "A")
    pilot.hold("left", "Left")
    pilot.release("A")
    assert settle(pilot).yaw == pytest.approx(1.0, abs=1e-3)


def test_after_a_full_stop_a_stick_must_move_to_count_again():
    pilot = Pilot()
    pilot.hold("ahead", "pad left stick up", 0.8)
    settle(pilot)
    pilot.hold("full stop", "pad A")
    pilot.hold("ahead", "pad left stick up", 0.79)  # the stick trembles
    assert settle(pilot).full_stop
    pilot.hold("ahead", "pad left stick up", 0.5)
    assert settle(pilot).surge == pytest.approx(0.5, abs=1e-3)


def test_a_full_stop_holds_until_a_hand_moves():
    pilot = steering_at(0.8, 0.0)
    pilot.wheel(8.0)
    settle(pilot)
    pilot.hold("full stop", "Space")
    assert settle(pilot) == (0.0, 0.0, 0.0, 0.0, True)
    pilot.point(0.8001, 0.0)
    assert settle(pilot).full_stop
    pilot.point(0.7, 0.0)
    helm = settle(pilot)
    assert not helm.full_stop
    assert helm.yaw < -0.1
    assert helm.surge == pytest.approx(0.0, abs=1e-3)


def test_a_steering_key_takes_the_helm_from_a_resting_pointer():
    pilot = steering_at(0.9, 0.0)
    assert settle(pilot).yaw < -0.5
    pilot.hold("left", "A")
    assert settle(pilot).yaw == pytest.approx(1.0, abs=1e-3)
    pilot.release("A")
    assert settle(pilot).yaw == pytest.approx(0.0, abs=1e-3)


def test_leaving_the_window_lets_go():
    pilot = steering_at(0.9, 0.9)
    settle(pilot)
    pilot.pointer_left()
    assert settle(pilot).yaw == pytest.approx(0.0, abs=1e-3)
    pilot.hold("ahead", "W")
    pilot.release_all()
    assert settle(pilot).surge == pytest.approx(0.0, abs=1e-3)


EVENTS = st.lists(
    st.one_of(
        st.tuples(st.just("point"), st.floats(-2, 2), st.floats(-2, 2)),
        st.tuples(st.just("hold"), st.just("ahead"), st.just("mouse left")),
        st.tuples(st.just("hold"), st.just("astern"), st.just("mouse right")),
        st.tuples(st.just("release"), st.sampled_from(["mouse left", "mouse right", "x"])),
        st.tuples(st.just("wheel"), st.floats(-3, 3)),
        st.tuples(
            st.just("hold"), st.sampled_from(["left", "up", "ahead", "rise"]), st.just("x"),
            st.floats(0, 1),
        ),
        st.tuples(st.just("pointer_left")),
    ),
    max_size=40,
)  # fmt: skip


@given(EVENTS)
def test_no_hand_asks_for_too_much_or_makes_the_helm_jump(events):
    pilot = Pilot()
    before = pilot.helm(DT)
    for name, *arguments in events:
        getattr(pilot, name)(*arguments)
        helm = pilot.helm(DT)
        assert all(-1.0 <= value <= 1.0 for value in helm[:4])
        assert all(abs(a - b) < 0.5 for a, b in zip(helm[:4], before[:4], strict=True))
        before = helm


def test_the_dead_zone_is_dead():
    helm = settle(steering_at(DEAD_ZONE * 0.99, -DEAD_ZONE * 0.99))
    assert helm[:4] == pytest.approx((0.0, 0.0, 0.0, 0.0))


def settled_at(x, y, **settings):
    pilot = Pilot(Settings(**settings))
    pilot.point(0.0, 0.5)
    pilot.point(x, y)
    pilot.hold("ahead", "W")
    return settle(pilot)


def test_the_mouse_is_as_the_settings_say():
    usual = settled_at(0.5, 0.5)
    assert settled_at(0.5, 0.5, mouse=MouseSettings(invert_pitch=True)).pitch == -usual.pitch
    still = settled_at(0.5, 0.5, mouse=MouseSettings(steer=False))
    assert (still.yaw, still.pitch) == (0.0, 0.0)
    assert still.surge > 0.9
    quick = settled_at(0.5, 0.5, mouse=MouseSettings(sensitivity=2.0))
    assert quick.yaw == pytest.approx(-1.0, abs=1e-3)
    assert quick.yaw < 1.5 * usual.yaw


def test_comfort_asks_for_a_share_of_thrust_and_rudder():
    usual, calm = (
        settled_at(0.9, 0.5),
        settled_at(0.9, 0.5, comfort=ComfortSettings(acceleration=0.5)),
    )
    assert calm[:2] == pytest.approx((0.5 * usual.surge, 0.5 * usual.yaw))
    assert calm.pitch == usual.pitch
