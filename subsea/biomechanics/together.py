"""Simulate many bodies in lanes (`kernels.lanes`): other species, durations and ends for each.

A *course* of swimming is a generator that yields one `Bout` after another and receives its frames.
`swim_course` runs a course alone. `swim_together` runs many side by side, with the same bits.
"""

from collections.abc import Generator, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.biomechanics.body import MUSCLES, NODES, Body, Floats, Material
from subsea.biomechanics.controllers import muscle_lengths
from subsea.biomechanics.reactive_water import Sections
from subsea.biomechanics.simulation import BodyState, simulate, ticks_of
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK, advance
from subsea.kernels import kernel
from subsea.kernels.lanes import LANES, as_lanes, gather, take_lane


class Bout(NamedTuple):
    """A body, its state, which changes, and its contractions (6 T, 12), as of `simulate`."""

    body: Body
    state: BodyState
    contraction: Floats


Found = TypeVar("Found")
Course = Generator[Bout, Floats, Found]
"""It yields bouts, receives the nodes (T, 23, 3) of each after every tick, and returns what it
found."""


def swim_course(course: Course[Found]) -> Found:
    """Run a course alone and return what it found."""
    try:
        bout = next(course)
        while True:
            bout = course.send(simulate(*bout))
    except StopIteration as end:
        found: Found = end.value
        return found


def swim_together(courses: Sequence[Course[Found]]) -> list[Found]:
    """Run courses side by side and return what each found; the states are of different bodies."""
    found: dict[int, Found] = {}
    frames: dict[int, Floats | None] = dict.fromkeys(range(len(courses)))
    while frames:
        bouts: dict[int, Bout] = {}
        for k, seen in frames.items():
            try:
                bouts[k] = next(courses[k]) if seen is None else courses[k].send(seen)
            except StopIteration as end:
                found[k] = end.value
        frames = dict(zip(bouts, simulate_many(list(bouts.values())), strict=True))
    return [found[k] for k in range(len(courses))]


def simulate_many(bouts: Sequence[Bout]) -> list[Floats]:
    """Advance the states of several bodies, and return the nodes of each, as `simulate` does.

    Bodies of one kind of water with about as many ticks share lanes.
    """
    frames: list[Floats] = [np.empty((0, NODES, 3))] * len(bouts)
    order = sorted(range(len(bouts)), key=lambda k: (_slender(bouts[k]), len(bouts[k].contraction)))
    begin = 0
    while begin < len(order):
        group = order[begin : begin + LANES]
        group = [k for k in group if _slender(bouts[k]) == _slender(bouts[group[0]])]
        begin += len(group)
        if len(group) == 1:
            frames[group[0]] = simulate(*bouts[group[0]])
            continue
        for k, nodes in zip(group, _in_lanes([bouts[k] for k in group]), strict=True):
            frames[k] = nodes
    return frames


def _slender(bout: Bout) -> bool:
    """True of a body in the water of slender bodies, false in Tu's."""
    return bool(bout.body.sections.added[-1] > 0.0)


def _in_lanes(bouts: Sequence[Bout]) -> list[Floats]:
    """Simulate 2 to LANES bouts in one kind of water."""
    ticks = np.array([ticks_of(bout.contraction) for bout in bouts])
    muscles = np.empty((len(bouts), ticks.max() * STEPS_PER_TICK, MUSCLES))
    for lane, bout in zip(muscles, bouts, strict=True):
        steps = len(bout.contraction)
        lane[:steps] = muscle_lengths(bout.body, bout.contraction)
        lane[steps:] = bout.body.length[:MUSCLES]  # relaxed: nobody reads how it goes on
    states = BodyState(
        *(np.stack(parts) for parts in zip(*(bout.state for bout in bouts), strict=True))
    )
    materials = [bout.body.material for bout in bouts]
    sections = zip(*(material.sections for material in materials), strict=True)
    mass, length, stiffness, viscosity, drag = (
        np.stack([np.atleast_1d(material[k]) for material in materials]) for k in range(5)
    )
    water = Sections(*(np.stack(rows) for rows in sections))
    stacked = Material(mass, length, stiffness, viscosity, drag, water)  # type: ignore[arg-type]
    frames = np.empty((len(bouts), ticks.max(), NODES, 3))
    advance_lanes(states, stacked, muscles, ticks, frames)
    for lane, bout in enumerate(bouts):
        for old, new in zip(bout.state, states, strict=True):
            old[:] = new[lane]
    return [frames[lane, : ticks[lane]].copy() for lane in range(len(bouts))]


@kernel
def advance_lanes(
    states: BodyState, bodies: Material, muscles: Array, ticks: Ints, frames: Array
) -> None:
    """Advance n bodies, 1 to LANES, each by its own number of ``ticks`` (n,), in still water.

    Rows of all arrays are bodies, those of the drag (n, 1), of ``muscles`` (n, 6 T, 12). Writes
    ``frames`` (n, T, 23, 3): the nodes after every tick of a body.
    """
    x, v, watch = states
    who, water = np.arange(len(ticks)), bodies.sections
    all_x, all_v, all_watch = gather(x, who), gather(v, who), gather(watch, who)
    sections = Sections(
        as_lanes(gather(water.added, who)), as_lanes(gather(water.flux, who)),
        as_lanes(gather(water.cross, who)), as_lanes(gather(water.heave, who)),
        as_lanes(gather(water.skin, who)),
    )  # fmt: skip
    material = Material(
        as_lanes(gather(bodies.mass, who)), as_lanes(gather(bodies.length, who)),
        as_lanes(gather(bodies.stiffness, who)), as_lanes(gather(bodies.viscosity, who)),
        as_lanes(gather(bodies.drag, who))[0], sections,
    )  # fmt: skip
    part = np.empty((STEPS_PER_TICK, MUSCLES, LANES))
    still, force = np.zeros(3), as_lanes(np.zeros((NODES, 3, LANES)))
    for tick in range(ticks.max()):
        for step in range(STEPS_PER_TICK):
            for muscle in range(MUSCLES):
                for k in range(LANES):
                    row = min(k, len(ticks) - 1)
                    part[step, muscle, k] = muscles[row, tick * STEPS_PER_TICK + step, muscle]
        advance(
            as_lanes(all_x), as_lanes(all_v), material, as_lanes(part), still, force, STEP,
            as_lanes(all_watch),
        )  # fmt: skip
        for k in range(len(ticks)):
            if tick < ticks[k]:
                take_lane(all_x, k, frames[k, tick])
            if tick == ticks[k] - 1:
                take_lane(all_x, k, x[k])
                take_lane(all_v, k, v[k])
                take_lane(all_watch, k, watch[k])
