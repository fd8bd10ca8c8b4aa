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


def test_without_input_the_helm_is_neutral():
    assert settle(Pilot()) == (0.0, 0.0, 0.0, 0.0, False)


def test_an_entering_pointer_takes_over_gently_once_it_moves():
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
def test_the_submarine_turns_to_the_pointer(x, y, yaw, pitch):
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
def test_every_manoeuvre_lasts_while_held(action, field, sign):
    pilot = Pilot()
    pilot.hold(action, "x")
    assert getattr(settle(pilot), field) == pytest.approx(sign, abs=1e-3)
    pilot.release("x")
    assert getattr(settle(pilot), field) == pytest.approx(0.0, abs=1e-3)


def test_the_strongest_input_counts():
    pilot = Pilot()
    pilot.hold("ahead", "pad left stick up", 0.4)
    assert settle(pilot).surge == pytest.approx(0.4, abs=1e-3)
    pilot.hold("ahead", "W")
    assert settle(pilot).surge == pytest.approx(1.0, abs=1e-3)
    pilot.release("W")
    assert settle(pilot).surge == pytest.approx(0.4, abs=1e-3)
    pilot.hold("ahead", "pad left stick up", 0.0)
    assert settle(pilot).surge == pytest.approx(0.0, abs=1e-3)


def test_an_action_lasts_until_all_of_its_keys_are_released():
    pilot = Pilot()
    pilot.hold("left", "A")
    pilot.hold("left", "Left")
    pilot.release("A")
    assert settle(pilot).yaw == pytest.approx(1.0, abs=1e-3)


def test_a_resting_stick_does_not_end_a_full_stop():
    pilot = Pilot()
    pilot.hold("ahead", "pad left stick up", 0.8)
    settle(pilot)
    pilot.hold("full stop", "pad A")
    pilot.hold("ahead", "pad left stick up", 0.79)  # the stick trembles
    assert settle(pilot).full_stop
    pilot.hold("ahead", "pad left stick up", 0.5)
    assert settle(pilot).surge == pytest.approx(0.5, abs=1e-3)


def test_a_full_stop_lasts_until_there_is_input():
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


def test_leaving_the_window_releases_the_helm():
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
def test_the_helm_is_bounded_and_continuous(events):
    pilot = Pilot()
    before = pilot.helm(DT)
    for name, *arguments in events:
        getattr(pilot, name)(*arguments)
        helm = pilot.helm(DT)
        assert all(-1.0 <= value <= 1.0 for value in helm[:4])
        assert all(abs(a - b) < 0.5 for a, b in zip(helm[:4], before[:4], strict=True))
        before = helm


def test_the_dead_zone_has_no_effect():
    helm = settle(steering_at(DEAD_ZONE * 0.99, -DEAD_ZONE * 0.99))
    assert helm[:4] == pytest.approx((0.0, 0.0, 0.0, 0.0))


def settled_at(x, y, **settings):
    pilot = Pilot(Settings(**settings))
    pilot.point(0.0, 0.5)
    pilot.point(x, y)
    pilot.hold("ahead", "W")
    return settle(pilot)


def test_the_mouse_follows_its_settings():
    usual = settled_at(0.5, 0.5)
    assert settled_at(0.5, 0.5, mouse=MouseSettings(invert_pitch=True)).pitch == -usual.pitch
    still = settled_at(0.5, 0.5, mouse=MouseSettings(steer=False))
    assert (still.yaw, still.pitch) == (0.0, 0.0)
    assert still.surge > 0.9
    quick = settled_at(0.5, 0.5, mouse=MouseSettings(sensitivity=2.0))
    assert quick.yaw == pytest.approx(-1.0, abs=1e-3)
    assert quick.yaw < 1.5 * usual.yaw


def test_comfort_reduces_thrust_and_rudder():
    usual = settled_at(0.9, 0.5)
    calm = settled_at(0.9, 0.5, comfort=ComfortSettings(acceleration=0.5))
    assert calm[:2] == pytest.approx((0.5 * usual.surge, 0.5 * usual.yaw))
    assert calm.pitch == usual.pitch
