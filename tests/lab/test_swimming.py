"""Beats, speeds and turns of paths in closed form."""

import numpy as np
import pytest

from subsea.lab.swimming import Swimming, amplitude_at, beat_of, joined, swimming
from subsea.repertoire import SEGMENTS
from subsea.state import EAT, ESCAPE, PREDATOR, WANDER
from tests.support.records import LENGTH, a_record

TICK_S = 1 / 30
FAST = SEGMENTS.index("swim_fast")
LEFT = SEGMENTS.index("turn_left_sharp")


def turned(angle, pitch=0.0):
    """Quaternions of upright bodies that head `angle` (…) rad left of x, with the nose up."""
    up, half = np.sqrt(0.5), 0.5 * np.asarray(angle, float)
    c, s = np.cos(half), np.sin(half)
    w, x, y, z = (c * up, c * up, s * up, s * up)
    a, b = np.cos(pitch / 2), np.sin(pitch / 2)  # then about the body's right (z)
    return np.stack([w * a - z * b, x * a + y * b, y * a - x * b, z * a + w * b], axis=-1)


def straight(seconds=60.0, speed=2.0, frequency=3.7, amplitude=0.18, length=LENGTH, **changed):
    """One fish that swims along x, lengths a second, with a beating tail."""
    time = TICK_S * np.arange(round(seconds / TICK_S))
    place = np.zeros((len(time), 1, 3))
    place[:, 0, 0] = length * speed * time
    place[..., 2] = -200.0
    tail = place - (0.6 * length, 0, 0)
    tail[:, 0, 1] += 0.5 * amplitude * length * np.sin(2 * np.pi * frequency * time)
    given = {"tail": tail, "length": np.full(1, length, np.float32)} | changed
    return a_record(place, tick_s=TICK_S, time=time, **given)


def only(record, slowest=0.1):
    (found,) = swimming(record, np.full(record.position.shape[1], slowest)).values()
    return found


@pytest.mark.parametrize(
    ("frequency", "stretches"),
    [(0.5, 7), (0.8, 15), (1.3, 15), (1.6, 30), (2.4, 30), (3.7, 60), (6.3, 60), (10.0, 60)],
)
def test_a_beating_tail_has_its_strouhal_number_and_stride(frequency, stretches):
    """Stretches are of one to eight seconds: the shortest that hold three beats."""
    found = only(straight(frequency=frequency))
    assert len(found.strouhal) == stretches
    assert found.frequency == pytest.approx(frequency, rel=0.02)
    assert np.median(found.amplitude) == pytest.approx(0.18, rel=0.03)
    assert np.median(found.strouhal) == pytest.approx(frequency * 0.18 / 2.0, rel=0.03)
    assert found.stride == pytest.approx(2.0 / frequency, rel=0.03)
    assert found.speed == pytest.approx(2.0, rel=1e-3)
    assert found.straight == (0.0, 0.0) and len(found.radius) == 0


@pytest.mark.parametrize("phase", np.linspace(0.0, np.pi, 7))
@pytest.mark.parametrize("beats", [1.7, 2.0, 2.4, 3.1, 6.3, 10.0])
def test_the_frequency_of_few_beats_on_a_curved_path(beats, phase):
    """Of a tail that does not beat in a pure sine, by a body that drifts and turns."""
    time = TICK_S * np.arange(30)
    angle = 2 * np.pi * beats * time + phase
    tail = 0.09 * (np.sin(angle) + 0.05 * np.sin(2 * angle)) + 0.2 * time - 0.3 * time**2
    frequency, amplitude = beat_of(tail[None], TICK_S)
    assert frequency == pytest.approx(beats, rel=0.05)
    assert amplitude == pytest.approx(0.18, rel=0.2 if beats < 2.5 else 0.1)


def test_a_slow_swing_is_not_read_as_a_beat():
    """A swing of one beat in the longest stretch looks like a curve."""
    assert len(only(straight(frequency=0.13)).strouhal) == 0


def test_a_parabola_is_not_a_beat():
    time = np.linspace(0, 2, 60, endpoint=False)
    beat = 0.1 * np.sin(2 * np.pi * 3 * time)
    frequency, amplitude = beat_of(np.stack([beat, beat + time**2 - 3 * time]), time[1])
    assert frequency == pytest.approx(3.0, rel=0.01)
    assert amplitude == pytest.approx(0.2, rel=0.02)


def test_a_course_that_wanders_does_not_widen_the_beat():
    """A swing of half the frequency and of equal amplitude beside the beat of the tail."""
    time = TICK_S * np.arange(60)
    wander = 0.09 * np.sin(2 * np.pi * 1.6 * time)
    tail = 0.09 * np.sin(2 * np.pi * 4.0 * time + 0.5) + wander
    assert amplitude_at(tail[None], np.array([4.0]), TICK_S) == pytest.approx(0.18, rel=0.08)


@pytest.mark.parametrize("yaw", [3.0, 20.0])
def test_the_snout_and_the_head_sway_with_the_beat(yaw):
    """A head that yaws about the origin of the body, 0.4 lengths behind the nose."""
    time = TICK_S * np.arange(1800)
    beat = np.sin(2 * np.pi * 3.7 * time)
    found = only(straight(orientation=turned(np.radians(0.5 * yaw) * beat)[:, None]))
    assert np.median(found.yaw) == pytest.approx(yaw, rel=0.03)
    snout = 2 * 0.4 * np.radians(0.5 * yaw)
    assert np.median(found.snout_over_tail) == pytest.approx(snout / 0.18, rel=0.05)


def test_the_roll_is_that_beside_its_mean():
    time = TICK_S * np.arange(1800)
    level = turned(0 * time)
    roll = np.radians(4.0) * np.sin(2 * np.pi * 3.7 * time) + np.radians(12.0)
    w, x, y, z = level.T
    c, s = np.cos(roll / 2), np.sin(roll / 2)  # about the body's x axis, on the right
    rolled = np.stack([w * c - x * s, x * c + w * s, y * c + z * s, z * c - y * s], axis=-1)
    found = only(straight(orientation=rolled[:, None]))
    assert np.median(found.roll) == pytest.approx(4.0, rel=0.05)
    assert only(straight(orientation=level[:, None])).roll == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("bend", [50.0, -50.0, 10.0])
def test_a_body_bends_into_its_turn_or_against_it(bend):
    """On a circle to the left, the tail lies `bend` degrees off the line behind the head."""
    record = circle(rate=2.0)
    heading = 2.0 * TICK_S * np.arange(len(record.position))
    behind = heading + np.pi - np.radians(bend)
    record.tail[:] = record.position
    record.tail[:, 0, 0] += 0.6 * LENGTH * np.cos(behind)
    record.tail[:, 0, 1] += 0.6 * LENGTH * np.sin(behind)
    into, bent = only(record).into
    assert bent == (0 if bend == 10.0 else pytest.approx(len(heading), abs=15))
    assert into == (bent if bend > 0.0 else 0)
    # On a circle of half a length the centre of mass is pulled inwards; escapes do not count.
    pull = 4.0 * 0.5
    assert np.median(only(circle(rate=2.0)).acceleration) == pytest.approx(pull, rel=0.02)
    assert not len(only(circle(segment=SEGMENTS.index("cstart_left_wide"))).acceleration)


def test_a_still_tail_has_no_beat():
    assert len(only(straight(amplitude=0.0)).strouhal) == 0


def test_beats_are_those_of_swims():
    """Fishes row and turn with other strokes."""
    for name in ("row_forward", "turn_left_sharp"):
        segment = np.full((1800, 1), SEGMENTS.index(name))
        assert len(only(straight(segment=segment)).strouhal) == 0
    half = np.where(np.arange(1800) < 900, FAST, LEFT)[:, None]
    assert len(only(straight(segment=half)).strouhal) == 30


def test_a_body_that_sways_with_a_straight_tail_does_not_beat():
    record = straight(amplitude=0.0)
    sway = 0.1 * LENGTH * np.sin(2 * np.pi * 3.7 * record.time)[:, None]
    record.position[..., 1] += sway
    record.tail[..., 1] += sway
    assert len(only(record).strouhal) == 0


def circle(radius=0.5, rate=0.9, seconds=30.0, segment=FAST):
    """One fish on a circle to the left, radius in lengths and rate in rad/s."""
    angle = rate * TICK_S * np.arange(round(seconds / TICK_S))
    place = LENGTH * radius * np.stack([np.sin(angle), -np.cos(angle), 0 * angle], axis=-1)
    segments = np.full((len(angle), 1), segment)
    return a_record(
        place[:, None] - (0, 0, 200), turned(angle)[:, None], tick_s=TICK_S, segment=segments,
        time=TICK_S * np.arange(len(angle)),
    )  # fmt: skip


@pytest.mark.parametrize("radius", [0.15, 0.5, 1.2])
def test_the_radius_of_a_circle(radius):
    found = only(circle(radius))
    assert found.radius == pytest.approx([radius], rel=0.02)  # of one long turn


@pytest.mark.parametrize("begin_s", [4.0, 4.2, 4.5, 4.7])
def test_the_radius_of_a_short_turn_does_not_depend_on_its_tick(begin_s):
    """Half a circle of 0.25 L in 1.25 s, between two straight ways; chords are 6% shorter."""
    time = TICK_S * np.arange(360)
    angle = np.pi * np.clip((time - begin_s) / 1.25, 0.0, 1.0)
    way = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    place = LENGTH * 0.25 * np.pi / 1.25 * TICK_S * np.cumsum(way, axis=0) - (0, 0, 200)
    found = only(a_record(place[:, None], turned(angle)[:, None], tick_s=TICK_S, time=time))
    assert found.radius == pytest.approx([0.235], rel=0.04)


def test_heading_changes_count_by_the_segment():
    part, whole = only(circle(segment=FAST)).straight
    assert part == whole > 0
    part, again = only(circle(segment=LEFT)).straight
    assert part == 0.0 and again == pytest.approx(whole)


def test_pitch_and_stops_are_shares():
    steep = np.radians(30.0) * (np.arange(1800) < 450)
    found = only(straight(orientation=turned(0 * steep, steep)[:, None], speed=0.15), slowest=0.2)
    assert found.pitched == (450, 1800)
    assert found.idle[0] == found.idle[1] == found.hovering[0] == 119
    assert found.longest_hover_s == pytest.approx(59.5)
    assert only(straight(speed=0.3)).longest_hover_s == 0.0
    rowing = np.full((1800, 1), SEGMENTS.index("row_forward"))
    assert only(straight(speed=0.15, segment=rowing), slowest=0.2).idle == (0.0, 0.0)


def test_haste_is_flight_or_a_hunt_of_a_predator():
    for doing, kind, hasty in ((ESCAPE, 0, 119), (EAT, 0, 0), (EAT, PREDATOR, 119), (WANDER, 0, 0)):
        record = straight(intention=np.full((1800, 1), doing), kind=np.full(1, kind, np.uint8))
        assert len(only(record).hasty) == hasty


def test_samples_of_several_records_are_joined():
    one, two = only(straight()), only(straight(speed=0.15))
    both = joined([one, two])
    assert isinstance(both, Swimming)
    assert len(both.strouhal) == len(one.strouhal) + len(two.strouhal)
    assert both.pitched == (0.0, 3600.0) and both.longest_hover_s == two.longest_hover_s
