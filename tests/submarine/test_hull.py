"""The hull against closed forms, and against random pilots."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.solids import from_pillar, from_rock, height_at
from subsea.state import Submarine
from subsea.submarine import vessel as hull
from subsea.submarine.vessel import NEUTRAL, Helm
from tests.support.seas import bare_sea

DT = 0.033


def submarine(position=(0.0, 0.0, -300.0), heading=0.0):
    return Submarine(
        position=np.array(position, np.float64),
        velocity=np.zeros(3),
        angles=np.array([heading, 0.0]),
        rates=np.zeros(2),
        previous_position=np.array(position, np.float64),
        previous_angles=np.array([heading, 0.0]),
    )


def flat(depth, **solids):
    return bare_sea(-depth, 20000.0, 21000.0, **solids)


ALONG = np.linspace(-1400.0, 1400.0, 281)
DUNES = -600.0 + 70.0 * np.sin(ALONG / 67.0) * np.cos(ALONG[:, None] / 67.0)
DUNES = DUNES.astype(np.float32)
BAY, DEEP = bare_sea(DUNES), flat(5000.0)


def dunes(x, y):
    return height_at(BAY.floor, BAY.half_width, x, y)


def sail(boat, helm, seconds, around=DEEP):
    for _ in range(round(seconds / DT)):
        hull.step_hull(boat, helm, DT, around)
    return boat


@pytest.mark.parametrize("share", [0.1, 0.5, 1.0, -0.5, -1.0])
def test_speed_settles_where_thrust_balances_drag(share):
    boat = sail(submarine((0.0, 0.0, -2000.0)), Helm(surge=share), 60.0)
    full = hull.AHEAD_CM_S if share > 0 else hull.ASTERN_CM_S
    expected = hull.settled_speed(abs(share), full, hull.LINEAR_ALONG, hull.QUADRATIC_ALONG)
    assert boat.velocity[0] == pytest.approx(math.copysign(expected, share), rel=1e-3)
    assert np.abs(boat.velocity[1:]).max() < 1e-9


def test_full_thrust_settles_at_the_named_speeds():
    assert hull.settled_speed(1.0, 160.0, 0.3, 2.4e-3) == pytest.approx(160.0)
    rising = sail(submarine((0.0, 0.0, -4000.0)), Helm(heave=1.0), 20.0)
    assert rising.velocity[2] == pytest.approx(hull.HEAVE_CM_S, rel=1e-3)
    turning = sail(submarine((0.0, 0.0, -2000.0)), Helm(yaw=1.0), 20.0)
    assert turning.rates[0] == pytest.approx(hull.YAW_RAD_S, rel=1e-3)


def test_signs_are_left_and_up():
    boat = sail(submarine(), Helm(yaw=0.5, pitch=0.5), 2.0)
    assert boat.angles[0] > 0.1
    assert boat.angles[1] > 0.1
    ahead = hull.hull_axes(math.pi / 2, 0.0)[0]
    assert ahead == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)


def test_inertia_no_speed_at_once_and_none_lost_at_once():
    boat = submarine((0.0, 0.0, -2000.0))
    hull.step_hull(boat, Helm(surge=1.0), DT, DEEP)
    assert 0.0 < boat.velocity[0] < 5.0
    sail(boat, Helm(surge=1.0), 30.0)
    sail(boat, NEUTRAL, 1.0)
    assert 60.0 < boat.velocity[0] < 160.0


def test_full_stop_brakes_everything():
    boat = sail(submarine((0.0, 0.0, -2000.0)), Helm(1.0, 1.0, 1.0, 1.0), 10.0)
    sail(boat, Helm(1.0, 1.0, 1.0, 1.0, full_stop=True), 3.0)
    assert np.linalg.norm(boat.velocity) < 1.0
    assert abs(boat.rates[0]) < 0.01
    assert abs(boat.angles[1]) < 0.01


def test_no_helm_asks_more_of_a_passenger_than_is_comfortable():
    boat = submarine((0.0, 0.0, -2000.0))
    hardest = quickest = 0.0
    for helm in (Helm(1.0, 1.0, 1.0, 1.0), Helm(-1.0, -1.0, -1.0, -1.0), Helm(full_stop=True)):
        for _ in range(200):
            velocity, rate = boat.velocity.copy(), boat.rates[1]
            hull.step_hull(boat, helm, DT, DEEP)
            hardest = max(hardest, float(np.linalg.norm(boat.velocity - velocity)) / DT)
            quickest = max(quickest, abs(boat.rates[1] - rate) / DT)
            assert abs(boat.rates[1]) < math.radians(37.0)
    assert hardest == pytest.approx(hull.ACCELERATION_CM_S2)  # by the full stop
    assert 1.0 < quickest <= hull.RIGHTING_MOST


def test_pitch_is_limited_and_levels_itself():
    boat = submarine((0.0, 0.0, -2000.0))
    for _ in range(200):
        hull.step_hull(boat, Helm(pitch=1.0), DT, DEEP)
        assert boat.angles[1] <= hull.MAX_PITCH + 1e-12
    assert boat.angles[1] == pytest.approx(hull.MAX_PITCH, abs=1e-3)
    sail(boat, NEUTRAL, 4.0)
    assert abs(boat.angles[1]) < 0.01


def test_the_previous_state_is_kept_for_interpolation():
    boat = sail(submarine(), Helm(surge=1.0, yaw=1.0), 1.0)
    position, angles = boat.position.copy(), boat.angles.copy()
    hull.step_hull(boat, NEUTRAL, DT, BAY)
    assert (boat.previous_position == position).all()
    assert (boat.previous_angles == angles).all()


def test_it_follows_its_nose():
    boat = sail(submarine((0.0, 0.0, -2000.0)), Helm(surge=1.0), 10.0)
    boat.angles[0] = math.pi / 2
    sail(boat, Helm(surge=1.0), 4.0)
    course = math.atan2(boat.velocity[1], boat.velocity[0])
    assert course == pytest.approx(math.pi / 2, abs=0.05)


COMMAND = st.floats(-1.0, 1.0)
HELM = st.builds(Helm, COMMAND, COMMAND, COMMAND, COMMAND, st.booleans())
HELMS = st.lists(st.tuples(HELM, st.integers(5, 120)), min_size=1, max_size=8)


@given(HELMS, st.floats(0.0, math.tau), st.floats(0.0, 1200.0))
def test_no_pilot_leaves_the_sea_or_feels_a_jerk(helms, bearing, radius):
    start = (radius * math.cos(bearing), radius * math.sin(bearing), -300.0)
    boat = submarine(start, bearing)
    for helm, ticks in helms:
        for _ in range(ticks):
            before = boat.velocity.copy()
            hull.step_hull(boat, helm, DT, BAY)
            x, y, z = boat.position
            assert dunes(x, y) + 0.5 * hull.CLEARANCE_CM <= z <= -0.9 * hull.CLEARANCE_CM
            assert math.hypot(x, y) <= BAY.radius - 0.9 * hull.CLEARANCE_CM
            # A seabed that rises suddenly is the hardest that a visitor may feel.
            assert np.linalg.norm(boat.velocity - before) / DT < 350.0


@pytest.mark.parametrize("helm", [Helm(surge=1.0, pitch=-1.0), Helm(heave=-1.0)])
def test_a_dive_at_the_seabed_ends_softly_above_it(helm):
    boat, around = submarine(), flat(600.0)
    slowing = 0.0
    for _ in range(600):
        sinking = boat.velocity[2]
        hull.step_hull(boat, helm, DT, around)
        slowing = max(slowing, (boat.velocity[2] - sinking) / DT)
    assert 0.0 <= boat.position[2] + 600.0 - hull.CLEARANCE_CM < 15.0
    assert slowing < 200.0


def test_the_same_helms_give_the_same_bits():
    one, two = submarine(), submarine()
    for boat in (one, two):
        sail(boat, Helm(0.7, 0.3, -0.2, 0.1), 5.0, BAY)
    assert one.position.tobytes() == two.position.tobytes()
    assert one.angles.tobytes() == two.angles.tobytes()


PILLARS = np.array([(300.0, 0.0, 60.0, -150.0), (360.0, 80.0, 50.0, 40.0)])
ROCKS = np.array([(-250.0, 100.0, -560.0, 120.0, 90.0, 80.0, 0.4)])


def distance(boat):
    place = tuple(float(value) for value in boat.position)
    gaps = [from_pillar(row, place)[1] for row in PILLARS]
    return min(gaps + [from_rock(row, place)[1] for row in ROCKS])


@pytest.mark.parametrize(("start", "heading"), [((0.0, 5.0, -300.0), 0.0), ((0, 0, -530), 2.76)])
def test_a_run_at_a_solid_ends_softly_before_it(start, heading):
    boat, hardest = submarine(start, heading), 0.0
    around = flat(700.0, pillars=PILLARS, rocks=ROCKS)
    for _ in range(900):
        before = boat.velocity.copy()
        hull.step_hull(boat, Helm(surge=1.0), DT, around)
        hardest = max(hardest, float(np.linalg.norm(boat.velocity - before)) / DT)
        assert distance(boat) > 0.95 * hull.CLEARANCE_CM
    assert hardest < 300.0
    assert np.linalg.norm(boat.position - start) > 100.0


@given(HELMS, st.floats(0.0, math.tau), st.floats(-500.0, -60.0))
def test_no_pilot_touches_a_pillar_or_a_rock(helms, heading, depth):
    boat = submarine((0.0, 0.0, depth), heading)
    around = bare_sea(DUNES, pillars=PILLARS, rocks=ROCKS)
    for helm, ticks in helms:
        for _ in range(2 * ticks):
            before = boat.velocity.copy()
            hull.step_hull(boat, helm, DT, around)
            assert distance(boat) >= 0.49 * hull.CLEARANCE_CM
            x, y, z = boat.position
            assert z >= dunes(x, y) + 0.5 * hull.CLEARANCE_CM - 1e-9
            assert np.linalg.norm(boat.velocity - before) / DT < 900.0


def test_solids_that_are_far_change_nothing():
    one, two = submarine(), submarine()
    around = bare_sea(DUNES, pillars=PILLARS + [900, 0, 0, 0])
    for _ in range(60):
        hull.step_hull(one, Helm(surge=0.5), DT, BAY)
        hull.step_hull(two, Helm(surge=0.5), DT, around)
    assert one.position.tobytes() == two.position.tobytes()
