"""Free manoeuvres of an eel: bends and beats are prescribed, the water moves the fish.

An escape bends the body to a C that begins behind the head. The bend runs to the tail, and the
beat sets in (a C-start: Domenici & Blake 1997). Turns from rest and from a glide are the same,
slower. The size of the bend is searched that turns the fish as far as asked.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from capture.recording.spine_motion import SpineMotion, Stroke, in_world, pose_surface, shake
from capture.recording.spine_water import recoil_of, spine_strip, stride_of, unit_mass
from subsea.base.arrays import Array
from subsea.biomechanics.prescribed_wave import follow, start_momentum, swim
from subsea.biomechanics.solver import TICK_S
from subsea.fish.spine import MIDDLES, SpineGait, SpinePlan, pose_spine
from subsea.fish.surface import SurfacePlan

STEPS = 4  # of the water, in a tick; even
STAGE_S = 0.003  # s per cm of length, of either stage of a C-start (about)
LATE = 0.6  # share of the bend's time by which the tail follows the head
AT_ONCE = 0.25  # front part of the body that bends to a C at once
CLOSE = np.radians(0.01)
MOST_BEND = np.radians(420.0)  # of the path; stiff parts of the body follow it less


class Manoeuvre(NamedTuple):
    """A bend and a beat over some ticks."""

    ticks: int
    gait: SpineGait
    beats_from: float  # share of the time at which the beat sets in, over ``easing``
    easing: float  # share of the time; negative if the beat ceases
    speed: float  # of the start, body lengths per tick
    turn: float  # rad in total, left positive
    bend: int  # ticks until the body is straight again


class Passage(NamedTuple):
    """A manoeuvre at its ticks."""

    frame: Array  # (T + 1, 3): body lengths ahead and left, heading in rad
    stroke: Stroke
    around: Array  # (T + 1, n) directions of the units


def spine_manoeuvre(plan: SpinePlan, surface: SurfacePlan, name: str) -> SpineMotion:
    """Compute all frames of a free manoeuvre, such as ``cstart_left_wide``."""

    def pace(gait: SpineGait) -> float:
        return stride_of(plan, surface, gait) / gait.ticks_per_beat

    what = manoeuvre(plan, name, pace)
    bend = find_bend(plan, surface, what._replace(turn=abs(what.turn)))
    passage = move(plan, surface, what, -bend if what.turn < 0.0 else bend)
    moved = pose_surface(plan, surface, passage.stroke, passage.around)
    # The direction of the centre changes abruptly as the bend passes; the body frame turns evenly.
    frame = passage.frame.copy()
    frame[:, 2] = what.turn * ease(np.arange(len(frame)) / what.bend)
    lead = np.zeros_like(frame)
    lead[:, 2] = passage.frame[:, 2] - frame[:, 2]
    return in_world(plan, surface, shake(moved, lead, up=False), frame)


def manoeuvre(plan: SpinePlan, name: str, pace: Callable[[SpineGait], float]) -> Manoeuvre:
    """Timing and aim of the segment ``name``, from the ``pace`` of gaits in body lengths a tick."""
    kind, _, grade = name.rpartition("_")
    side = -1.0 if "right" in name else 1.0
    stages = round(2.0 * STAGE_S * plan.length / TICK_S)
    slow, medium, fast = plan.slow, plan.medium, plan.fast
    if kind.startswith("cstart"):
        turn, time = {"moderate": (70.0, stages), "wide": (135.0, round(1.3 * stages))}[grade]
        ticks = time + fast.ticks_per_beat // 2
        return Manoeuvre(ticks, fast, 0.4, 0.5, pace(slow), side * np.radians(turn), time)
    if grade == "rest":
        time = 4 * stages
        ticks = time + slow.ticks_per_beat // 2
        return Manoeuvre(ticks, slow, 0.5, 0.5, 0.0, side * np.radians(90.0), time)
    if grade == "glide":
        time = 3 * stages
        return Manoeuvre(time, medium, 2.0, 1.0, pace(medium), side * np.radians(90.0), time)
    if grade == "start":
        time = 2 * medium.ticks_per_beat
        return Manoeuvre(time, medium, 0.0, 0.6, 0.0, 0.0, time)
    time = 3 * medium.ticks_per_beat
    return Manoeuvre(time, medium, 0.0, -0.4, pace(medium), 0.0, time)


def find_bend(plan: SpinePlan, surface: SurfacePlan, what: Manoeuvre) -> float:
    """The greatest bend of the path from snout to tail, rad, that turns the fish by ``what.turn``.

    ValueError if the fish cannot turn so far.
    """

    def turned(bend: float) -> float:
        return float(move(plan, surface, what, bend).frame[-1, 2])

    least, most = (-MOST_BEND / 4, MOST_BEND / 4) if not what.turn else (0.0, MOST_BEND)
    return search_bend(turned, what.turn, least, most)


def search_bend(turned: Callable[[float], float], turn: float, a: float, b: float) -> float:
    """The bend between ``a`` and ``b`` that turns the fish by ``turn`` rad.

    By the Illinois variant of the false position. ValueError if the fish cannot turn so far.
    """

    def miss(bend: float) -> float:
        return turned(bend) - turn

    here, there = miss(a), miss(b)
    if not here < 0.0 < there:
        raise ValueError(f"no bend turns the fish by {np.degrees(turn):.0f} degrees")
    while True:
        c = (a * there - b * here) / (there - here)
        missed = miss(c)
        if abs(missed) < CLOSE:
            return c
        if missed * there < 0.0:
            a, here = b, there
        else:
            here *= 0.5
        b, there = c, missed


def move(plan: SpinePlan, surface: SurfacePlan, what: Manoeuvre, bend: float) -> Passage:
    """Let the fish bend, beat and move freely."""
    ticks = np.linspace(0.0, what.ticks, STEPS * what.ticks + 1)
    share = ticks / what.ticks
    beat = ticks / what.gait.ticks_per_beat
    eased = ease((share - what.beats_from) / abs(what.easing))
    amplitude = what.gait.amplitude * (eased if what.easing > 0 else 1.0 - eased)
    # Where its turn is mirrored the beat is too.
    stroke = Stroke(what.gait, beat, amplitude, 0.5 if what.turn < 0 else 0.0)
    after = LATE * np.maximum(MIDDLES - AT_ONCE, 0.0) / (1.0 - AT_ONCE)
    late = (ticks[:, None] / what.bend - after) / (1.0 - LATE)
    curved = np.sin(np.pi * np.clip(late, 0.0, 1.0)) ** 2
    around = -bend * np.cumsum(curved, axis=1) / curved.sum(axis=1).max()
    around -= around[:, [int(plan.centre * len(MIDDLES))]]
    spine = pose_spine(plan, beat + stroke.side, amplitude[:, None], around, unit_mass(surface))
    step = TICK_S / STEPS
    parts = spine_strip(plan, surface, spine.place, step, cyclic=False)
    start = np.array([what.speed * plan.length / TICK_S, 0.0, 0.0])
    track = swim(parts, step, start_momentum(parts, start))
    way = follow(track.velocity, 2.0 * step)[:: STEPS // 2]
    one = slice(None, None, STEPS)
    stroke = Stroke(what.gait, beat[one], amplitude[one], stroke.side)
    recoil = recoil_of(plan, surface, what.gait, stroke.beat + stroke.side)
    recoil *= stroke.amplitude[:, None] / what.gait.amplitude
    return Passage(
        without_recoil(way / (plan.length, plan.length, 1.0), recoil), stroke, around[one]
    )


def without_recoil(way: Array, recoil: Array) -> Array:
    """Frames (T, 3) that, shaken by the recoil, are those of ``way``; the first is at 0."""
    heading = way[:, 2] - recoil[:, 2]
    c, s = np.cos(heading), np.sin(heading)
    x = way[:, 0] - c * recoil[:, 0] + s * recoil[:, 1]
    y = way[:, 1] - s * recoil[:, 0] - c * recoil[:, 1]
    first = heading[0]
    c0, s0 = np.cos(first), np.sin(first)
    x, y = x - x[0], y - y[0]
    return np.stack([c0 * x + s0 * y, c0 * y - s0 * x, heading - first], axis=1)


def even_path(middle: Array, heading: Array) -> tuple[Array, Array]:
    """Even path, ahead + i left, and course of a steady beat.

    ``middle`` (T + 1,) is the centre of mass and ``heading`` (T + 1,) that of the body, rad.
    """
    share = np.linspace(0.0, 1.0, len(middle))
    turn = heading[-1] - heading[0]
    even = turn * share
    course = (heading - even)[:-1].mean() + even
    if abs(turn) < 1e-6:
        way = share * (middle[-1] - middle[0])
        path = (middle - way)[:-1].mean() + way
    else:
        spin = np.exp(1j * even)
        pivot = (middle[-1] - spin[-1] * middle[0]) / (1.0 - spin[-1])
        path = pivot + ((middle - pivot) / spin)[:-1].mean() * spin
    return path, course


def ease(share: Array) -> Array:
    """0 to 1 with a smooth beginning and end."""
    share = np.clip(share, 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))
