"""A long body: a chain of more rings than a fish's, with muscles on both sides all along.

The units and the water are those of the fish. The fins of a long body end in sharp edges: where
they become lower, the water behind them is shed.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.biomechanics.body import RING_LEFT, RING_UP, Body, Floats, Ints, connect
from subsea.biomechanics.reactive_water import DENSITY, section_coefficients
from subsea.biomechanics.simulation import BodyState
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK, Chain, advance_chain, longest_step

RING_SHARE = 0.7  # place of a node, as a share of half the height of body and fins
LEAST_SHARE = 0.2  # least mass of a node and stiffness of a unit, over the greatest: tips have fins
SAFETY = 0.9  # step of the solver over the longest stable one
LEVEL = np.array([1.0, -1.0, 1.0])
STILL = np.zeros(3)


class Outline(NamedTuple):
    """The shape of a body at its stations: nose, rings and tail; cm."""

    at: Array  # (n,) behind the snout
    half_width: Array  # (n,)
    half_height: Array  # (n,)
    height: Array  # (n,) of body and fins


class LongBody(NamedTuple):
    """A long body at rest, and how to simulate it."""

    body: Body
    chain: Chain
    substeps: int  # steps of the solver in a step of a fish

    @property
    def segments(self) -> int:
        """Number of segments with muscles."""
        return len(self.chain.kept) - 2


def build_long_body(
    outline: Outline, stiffness: float, viscosity: float, cross_drag: float, skin_drag: float
) -> LongBody:
    """Join rings of four nodes to a body of the density of water.

    ``stiffness``, g/tu², and ``viscosity``, g/tu, are those of units where the body is tallest. The
    rings are as wide as tall, as a thin body would leave its muscles no lever.
    """
    rings = len(outline.at) - 2
    units = np.concatenate(connect(rings, rings - 1))
    count = np.array([1, *[4] * rings, 2])
    nodes = np.zeros((count.sum(), 3))
    nodes[:, 0] = -np.repeat(outline.at, count)
    half = 0.5 * RING_SHARE * outline.height
    nodes[1:-2, 1] = np.outer(half[1:-1], RING_UP).ravel()
    nodes[1:-2, 2] = np.outer(half[1:-1], -RING_LEFT).ravel()
    nodes[-2:, 1] = half[-1] * np.array([1.0, -1.0])
    area = np.pi * outline.half_width * outline.half_height
    share = 0.5 * np.diff(outline.at)
    share = np.append(share, 0.0) + np.insert(share, 0, 0.0)
    mass = DENSITY * area * share / count
    mass = np.maximum(mass, LEAST_SHARE * mass.max())
    thick = np.maximum(half / half.max(), LEAST_SHARE)
    water = section_coefficients(
        np.diff(outline.at),
        np.array([0.0, *outline.height[1:]]),
        2.0 * outline.half_width,
        cross_drag,
        skin_drag,
    )
    height = outline.height[1:]
    kept = np.minimum(1.0, (height[1:] / height[:-1]) ** 2)
    flux = water.flux.copy()
    flux[:-1] = np.where(kept < 1.0, 0.25 * np.pi * DENSITY * height[:-1] ** 2, flux[:-1])
    sized = np.repeat(thick, count)[units].mean(axis=1)  # of thin parts less
    body = Body(
        rest=nodes,
        mass=np.repeat(mass, count),
        length=np.linalg.norm(nodes[units[:, 1]] - nodes[units[:, 0]], axis=1),
        stiffness=sized * stiffness,
        viscosity=sized * viscosity,
        drag=0.0,
        sections=water._replace(flux=flux),
    )
    substeps = int(np.ceil(STEP / (SAFETY * longest_step(body, units)[0])))
    return LongBody(body, Chain(body.material, units, np.append(kept, 0.0)), substeps)


def at_rest(long: LongBody) -> BodyState:
    """The body at rest, its head towards x."""
    rest = long.body.rest
    return BodyState(rest.copy(), np.zeros(rest.shape), np.array([np.inf, 0.0, np.inf]))


def bend(long: LongBody, state: BodyState, left: Array) -> Floats:
    """Advance ``state`` and return its nodes after every tick, (T, n, 3) in cm.

    ``left`` (T × steps, segments) are the contractions on the left side in each step of the solver.
    The right side gives way by as much.
    """
    body, per_tick = long.body, STEPS_PER_TICK * long.substeps
    contraction = left[:, :, None] * RING_LEFT
    muscles = body.length[: 4 * long.segments] * (
        1.0 - contraction.reshape(len(left), 4 * long.segments)
    )
    force = np.zeros(state.x.shape)
    frames = np.empty((len(left) // per_tick, *state.x.shape))
    for tick, part in enumerate(np.split(muscles, len(frames))):
        advance_chain(
            state.x,
            state.v,
            long.chain,
            part,
            STILL,
            force,
            STEP / long.substeps,
            state.watch,
        )
        for values in (state.x, state.v):  # fins keep the body upright
            values[:] = 0.5 * (values + LEVEL * values[_upside_down(len(values))])
        frames[tick] = state.x
    return frames


@cache
def _upside_down(nodes: int) -> Ints:
    """The node below each node of the upper side, and the reverse."""
    rings = np.arange(1, nodes - 2).reshape(-1, 4)[:, ::-1].ravel()
    return np.concatenate([[0], rings, [nodes - 1, nodes - 2]])


def midline(frames: Floats) -> Floats:
    """Middles (…, stations, 3) of snout, rings and tail of nodes (…, n, 3)."""
    rings = frames[..., 1:-2, :]
    rings = rings.reshape(*rings.shape[:-2], -1, 4, 3).mean(axis=-2)
    tail = frames[..., -2:, :].mean(axis=-2, keepdims=True)
    return np.concatenate([frames[..., :1, :], rings, tail], axis=-2)
