"""The secondary controller: segments, speeds and steering from a goal."""

from itertools import product

import numpy as np
import pytest

from subsea.geometry.rotation import about, matrix, multiply, quaternion
from subsea.motor.controller import TILTED, command
from subsea.motor.playback import play
from subsea.repertoire import SEGMENTS
from subsea.repertoire.blending import LEVELS, TIGHTEST
from subsea.state import Clock
from tests.support.scenes import everyone

TICK = 0.033
STILL = np.zeros(3)
UPRIGHT = np.array(about(1.0, 0.0, 0.0, np.pi / 2))


def _ask(fishes, library, azimuth_deg=0.0, climb_deg=0.0, speed=0.6, ticks=1, tick=0):
    """Give every fish a fixed goal and advance; returns the path of the first one (T + 1, 3)."""
    a, c = np.radians(azimuth_deg), np.radians(climb_deg)
    fishes.goal_direction[:] = np.cos(a) * np.cos(c), np.sin(a) * np.cos(c), np.sin(c)
    fishes.goal_speed[:] = speed
    path = [fishes.position[0].copy()]
    for k in range(ticks):
        command(everyone(fishes), fishes, library, Clock(1, tick + k, TICK))
        play(everyone(fishes), fishes, library, TICK)
        path.append(fishes.position[0].copy())
    return np.array(path)


@pytest.fixture
def fish(make_fishes):
    fishes = make_fishes(1, "swim_medium")
    fishes.orientation[:] = UPRIGHT
    return fishes


@pytest.mark.parametrize(
    ("azimuth", "segment"),
    [
        (0, "swim_medium"),
        (0.5, "swim_medium"),
        (20, "turn_left_gradual"),
        (-20, "turn_right_gradual"),
        (120, "turn_left_sharp"),
        (-120, "turn_right_sharp"),
    ],
)
def test_the_angle_chooses_the_turn(fish, library, azimuth, segment):
    sway = np.degrees(library.sway[fish.row_a[0]])
    _ask(fish, library, azimuth_deg=azimuth - sway)  # of the course, which the sway leaves out
    assert SEGMENTS[fish.wanted_segment[0]] == segment


@pytest.mark.parametrize(
    ("speed", "segment"), [(0.25, "swim_slow"), (0.6, "swim_medium"), (1.0, "swim_fast")]
)
def test_the_speed_chooses_the_grade(fish, library, speed, segment):
    _ask(fish, library, speed=speed, ticks=60)
    assert SEGMENTS[fish.segment[0]] == segment


@pytest.mark.parametrize("speed", [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
def test_speed_is_continuous_between_the_grades(fish, library, speed):
    _ask(fish, library, speed=speed, ticks=120)
    path = _ask(fish, library, speed=speed, ticks=120)
    measured = np.linalg.norm(path[-1] - path[0]) / (120 * TICK)
    assert measured == pytest.approx(speed * library.speed[0, 2], rel=0.08)


@pytest.mark.parametrize("azimuth", [-170, -90, -30, 10, 35, 60, 100, 179])
def test_every_heading_is_reached_and_held(fish, library, azimuth):
    _ask(fish, library, azimuth_deg=azimuth, ticks=300)
    path = _ask(fish, library, azimuth_deg=azimuth, ticks=60)
    way = path[-1] - path[0]
    gap = np.degrees(np.arctan2(way[1], way[0])) - azimuth
    assert abs((gap + 180) % 360 - 180) < 6


@pytest.mark.parametrize("climb", [-80, -30, 15, 35])
def test_ascending_and_descending_are_swims_that_head_there(fish, library, climb):
    _ask(fish, library, climb_deg=climb, ticks=240)
    path = _ask(fish, library, climb_deg=climb, ticks=60)
    way = path[-1] - path[0]
    angle = np.degrees(np.arcsin(way[2] / np.linalg.norm(way)))
    assert angle == pytest.approx(np.clip(climb, -20, 20), abs=4)


def test_braking_stops_and_a_negative_speed_backs_off(fish, library):
    forward = _ask(fish, library, speed=0.6, ticks=60)
    braking = np.linalg.norm(np.diff(_ask(fish, library, speed=0.0, ticks=90), axis=0), axis=1)
    assert braking[-30:].max() < 0.1 * braking[0]
    assert np.abs(np.diff(braking)).max() < 0.3 * braking[0]  # it slows, it doesn't freeze
    back = _ask(fish, library, speed=-0.3, ticks=120)
    assert (back[-1] - back[60]) @ (forward[-1] - forward[0]) < 0


def test_a_swim_turns_by_bending_and_adds_no_yaw(fish, library):
    """The rate of turn lies between straight swim and gradual turn, in steps of a level."""
    recorded = library.turn[0, SEGMENTS.index("turn_left_gradual")]
    for bend, level in ((0.1, 1), (0.5, 6), (1.0, 12), (1.4, 14), (-0.7, -8)):
        turning = "turn_left_gradual" if level > 0 else "turn_right_gradual"
        fish.wanted_segment[:], fish.bend[:] = SEGMENTS.index(turning), bend
        for _ in range(24):
            play(everyone(fish), fish, library, TICK)
        before = _heading(fish)
        for _ in range(12):
            play(everyone(fish), fish, library, TICK)
        turn = (_heading(fish) - before + np.pi) % (2 * np.pi) - np.pi
        assert turn == pytest.approx(level / LEVELS * recorded, rel=0.02)


def _heading(fish):
    x = matrix(fish.orientation[0].astype(float))[:, 0]
    return float(np.arctan2(x[1], x[0]))


def test_the_bend_changes_by_a_level_a_row(fish, library):
    levels = []
    for k in range(40):
        _ask(fish, library, azimuth_deg=38 if k < 12 else -10, tick=k, speed=0.3)
        levels.append(library.level[fish.row_b[0]])
    assert TIGHTEST >= max(levels) > 5
    assert -TIGHTEST <= min(levels) < -3
    assert np.abs(np.diff(levels)).max() == 1


@pytest.mark.parametrize("goal", [0.15, 0.3, 0.6, 1.0, 1.7, 2.8])
def test_speed_comes_from_the_tempo_at_the_recorded_stride(fish, library, goal):
    """Strouhal number and stride do not depend on the speed: no slip between beat and way."""
    fish.burst[:] = 3.0
    _ask(fish, library, speed=goal, ticks=90)
    strides = []
    for k in range(60):
        _ask(fish, library, speed=goal, tick=k)
        beats = fish.tempo[0] * TICK / (12 * TICK)
        strides.append(np.linalg.norm(fish.velocity[0]) * TICK / beats)
    code = fish.segment[0]
    assert code <= 2
    np.testing.assert_allclose(strides, library.speed[0, code] * 12 * TICK, rtol=0.02)
    measured = np.mean(strides) * fish.tempo[0] / (12 * TICK)
    assert measured == pytest.approx(goal * library.speed[0, 2], rel=0.02)


def test_a_burst_is_reached_within_a_quarter_of_a_second(fish, library):
    fish.burst[:] = 3.0
    _ask(fish, library, speed=0.5, ticks=60)
    speeds = []
    for k in range(12):
        _ask(fish, library, speed=2.5, tick=k)
        speeds.append(np.linalg.norm(fish.velocity[0]) / library.speed[0, 2])
    assert speeds[8] > 0.9 * 2.5
    assert max(speeds) < 1.1 * 2.5
    fish.burst[:] = 1.5
    _ask(fish, library, speed=2.5, ticks=60)
    assert np.linalg.norm(fish.velocity[0]) == pytest.approx(1.5 * library.speed[0, 2], rel=0.03)


def test_a_ram_ventilator_never_stops(fish, library):
    fish.ram[:] = 0.4
    for speed in (0.0, -0.5):
        _ask(fish, library, speed=speed, ticks=90)
        assert np.linalg.norm(fish.velocity[0]) > 0.95 * 0.4 * library.speed[0, 2]


def test_after_a_while_of_the_same_another_swim_is_recommended(make_fishes, library):
    fishes = make_fishes(40, "swim_medium")
    fishes.orientation[:] = UPRIGHT
    fishes.identity[:] = np.linspace(0, 1, 40, endpoint=False)
    when, what = {}, {}
    for k in range(400):
        _ask(fishes, library, speed=0.6, tick=k)
        for i in np.flatnonzero(fishes.recommended >= 0):
            when.setdefault(int(i), k * TICK)
            what.setdefault(int(i), SEGMENTS[fishes.recommended[i]])
    assert len(when) == 40
    assert min(when.values()) > 3.9
    assert max(when.values()) < 9.3
    assert set(what.values()) == {"swim_slow", "swim_fast"}


def test_a_large_fish_turns_more_slowly(make_fishes, library):
    fishes = make_fishes(2, "swim_medium")
    fishes.orientation[:] = UPRIGHT
    fishes.scale[1], fishes.rate[1] = 4.0, 0.5
    _ask(fishes, library, azimuth_deg=20, ticks=30)
    heads = [matrix(np.array(multiply(q, UPRIGHT * [1, -1, -1, -1])))[:, 0] for q in
             fishes.orientation.astype(float)]  # fmt: skip
    assert heads[0][1] > 1.3 * heads[1][1] > 0


@pytest.mark.parametrize("species", ["fusilier", "blue_tang", "blacktip_reef_shark"])
def test_small_turns_are_tuned_finely(make_tank, species):
    """A fish that turns by less than 45° ends within 4.5° of its goal (SMC §6.2)."""
    for azimuth, speed in product((5, 15, 30, 45), (0.6, 1.0)):
        tank = make_tank(species).put("swim_fast")
        tank.aim(np.radians(azimuth), speed)
        tank.run(284)
        begin = tank.fishes.position[0].copy()
        tank.run(56)
        way = tank.fishes.position[0] - begin
        assert abs(np.degrees(np.arctan2(way[1], way[0])) - azimuth) < 4.5, (azimuth, speed)


def test_a_fish_with_its_nose_down_levels_by_its_fins_before_it_turns_or_swims(make_tank):
    """Recorded swims and sharp turns begin level."""
    tank = make_tank("blue_tang").put("row_forward")
    before = tank.fishes.orientation[0].astype(np.float64)
    tank.fishes.orientation[0] = multiply(quaternion(before), about(0.0, 0.0, 1.0, -1.0))
    tank.aim(np.radians(150.0), 0.8)
    steep, rowed = [], []
    for _ in range(120):
        tank.run(1)
        steep.append(abs(matrix(tank.fishes.orientation[0].astype(np.float64))[2, 0]) > TILTED)
        name = SEGMENTS[tank.fishes.wanted_segment[0]]
        rowed.append("row" in name)
    assert sum(steep) > 3
    assert not any(tilted and not rows for tilted, rows in zip(steep[:-1], rowed[1:], strict=True))
    assert not steep[-1]
    assert not rowed[-1]
