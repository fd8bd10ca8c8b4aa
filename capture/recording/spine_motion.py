"""Record a species that its spine moves: the same seven segments, by rule (KS part II).

There is no water: how far a beat takes the fish follows from a number of its plan, the slip.
"""

from typing import NamedTuple

import numpy as np

from capture.recording.segment import make_segment
from subsea.biomechanics.body import NODES, RING_LEFT, RING_UP, Floats
from subsea.biomechanics.body_plan import NODES_AT_STATION
from subsea.core.arrays import Array
from subsea.fish.spine import MIDDLES, Gait, SpinePlan, carried, flapped, spines
from subsea.fish.surface import SurfacePlan, along, fitted, rest_surface
from subsea.repertoire import Segment

PATH_STEPS = 20000  # in which the path of a segment is added up
RING_SHARE = 0.7  # of the body's half-width and half-height
FRAME_NODES = [0, 5, 6, 7, 8]  # of which the body frame is read
RING_ON_WING = 0.6  # half spans


class SpineMotion(NamedTuple):
    """A segment in world axes (x ahead, y up, z right), cm."""

    nodes: Floats  # (T + 1, 23, 3)
    points: Floats  # (T + 1, 426, 3) control points


class SwimPath(NamedTuple):
    """Where the fish's centre goes: a bend of `turn` rad between two places of a way."""

    way: float  # body lengths in all
    bend: tuple[float, float]  # body lengths from the start
    turn: float  # left positive
    even: bool  # whether the bend is an arc of a circle; else it begins and ends gently

    def heading(self, at: Array) -> Array:
        """Direction in rad at the places `at`; an even bend goes on before and behind."""
        share = (at - self.bend[0]) / (self.bend[1] - self.bend[0])
        if not self.even:
            share = np.clip(share, 0.0, 1.0)
            share = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        return np.asarray(self.turn * share)


def record_spine_segment(plan: SpinePlan, surface: SurfacePlan, name: str) -> Segment:
    """The segment ``name`` of a repertoire, with its control points.

    23 nodes are too few for the wave of an eel or the wing of a ray, so the surface always comes
    from the spine itself.
    """
    kind, _, grade = name.rpartition("_")
    motion = spine_motion(plan, surface, name)
    return make_segment(
        motion.nodes,
        plan.length,
        pattern={"swim": "forward", "turn_left": "left", "turn_right": "right"}[kind],
        grade=grade,
        cyclic=grade != "sharp",
        surface=motion.points,
    )


def spine_motion(plan: SpinePlan, surface: SurfacePlan, name: str) -> SpineMotion:
    """The motion of a segment, frame by frame from its start to its end."""
    gait, beats, path = gait_and_path(plan, name)
    beat = np.linspace(0.0, beats, beats * gait.ticks_per_beat + 1)
    travelled = beat * plan.stride(gait)
    heading = path.heading(travelled)
    # To the right everything is the mirror image of the left, and so the beat begins there.
    side = 0.5 if path.turn < 0 else 0.0
    around = path.heading(travelled[:, None] + plan.centre - MIDDLES) - heading[:, None]
    spine = spines(plan, beat + side, gait.amplitude, around, unit_mass(surface))
    rest = np.concatenate([rest_nodes(plan, surface), rest_surface(surface)])
    body = rest
    if plan.wings:
        body = flapped(plan.wings, rest, half_span(surface), beat, gait.amplitude)
    there = carried(spine, body)
    there = roll(there, bank_angle(plan, path, travelled))
    # The body frame neither sways nor leans, so that playback can steer it: it is the path's own.
    there[:, FRAME_NODES] = (plan.centre, 0.0, 0.0) + rest[FRAME_NODES] * (-1, 1, 1)
    c, s = np.cos(heading)[:, None], np.sin(heading)[:, None]
    ahead, up, right = np.moveaxis(there, -1, 0)
    place = path_points(path, travelled)
    world = np.stack(
        [
            place[:, None, 0] + c * ahead + s * right,
            up,
            -place[:, None, 1] - s * ahead + c * right,
        ],
        axis=-1,
    )
    world *= plan.length
    return SpineMotion(world[:, :NODES], np.asarray(fitted(world[:, NODES:]), np.float64))


def gait_and_path(plan: SpinePlan, name: str) -> tuple[Gait, int, SwimPath]:
    """Gait, number of beats and path of the segment ``name``, such as ``turn_left_gradual``."""
    kind, _, grade = name.rpartition("_")
    if kind == "swim":
        gait = {"slow": plan.slow, "medium": plan.medium, "fast": plan.fast}[grade]
        way = plan.stride(gait)
        return gait, 1, SwimPath(way, (0.0, way), 0.0, True)
    side = 1.0 if kind == "turn_left" else -1.0
    way = plan.stride(plan.medium)
    if grade == "gradual":
        turn = np.radians(plan.turn.gradual)
        return plan.medium, 1, SwimPath(way, (0.0, way), side * turn, True)
    # The snout enters the bend as the segment begins, and the tail has left it when it ends.
    way *= plan.turn.sharp_beats
    bend = plan.centre, way - (1.0 - plan.centre)
    return plan.medium, plan.turn.sharp_beats, SwimPath(way, bend, side * sharpness(plan), False)


def sharpness(plan: SpinePlan) -> float:
    """Angle of the sharp turn, rad."""
    return float(np.radians(plan.turn.sharp))


def path_points(path: SwimPath, travelled: Array) -> Array:
    """Places (T, 2) of the fish's centre, (ahead, left) of the start, body lengths."""
    at = np.linspace(0.0, path.way, PATH_STEPS + 1)
    heading = path.heading(0.5 * (at[1:] + at[:-1]))
    step = path.way / PATH_STEPS
    x, y = (np.concatenate([[0.0], np.cumsum(step * f(heading))]) for f in (np.cos, np.sin))
    return np.stack([np.interp(travelled, at, x), np.interp(travelled, at, y)], axis=-1)


def bank_angle(plan: SpinePlan, path: SwimPath, travelled: Array) -> Array:
    """How far the fish leans into the bend of its path, rad, positive with its left side down.

    In proportion to the curvature: `bank` is reached where a sharp turn bends most.
    """
    _, _, sharp = gait_and_path(plan, "turn_left_sharp")
    step = 1e-4
    most = sharp.turn / (sharp.bend[1] - sharp.bend[0]) * 15.0 / 8.0  # of the quintic
    curvature = (path.heading(travelled + step) - path.heading(travelled - step)) / (2.0 * step)
    return np.asarray(np.radians(plan.turn.bank) * np.clip(curvature / most, -1.0, 1.0))


def roll(points: Array, angle: Array) -> Array:
    """Points (T, p, 3) in path axes turned about the way ahead by `angle` (T,), rad."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    ahead, up, right = np.moveaxis(points, -1, 0)
    return np.stack([ahead, c * up + s * right, c * right - s * up], axis=-1)


def unit_mass(surface: SurfacePlan) -> Array:
    """What each unit of the spine weighs (n,), as its cross-section: no unit of its own."""
    back, belly = along(surface.back, MIDDLES), along(surface.belly, MIDDLES)
    return np.asarray(along(surface.width, MIDDLES) * (back - belly))


def half_span(surface: SurfacePlan) -> float:
    """From the spine to the tip of a wing, body lengths."""
    return surface.wing.span if surface.wing else max(width for _, width in surface.width)


def nodes_at_rest(plan: SpinePlan, surface: SurfacePlan) -> Array:
    """The 23 nodes (23, 3) of the fish at rest in body axes, cm."""
    nodes = rest_nodes(plan, surface)
    nodes[:, 0] = plan.centre - nodes[:, 0]
    nodes[:, 1] -= nodes[5:9, 1].mean()
    return nodes * plan.length


def rest_nodes(plan: SpinePlan, surface: SurfacePlan) -> Array:
    """The 23 nodes (23, 3) at rest, (distance behind the snout, up, right), body lengths.

    They lie in the order of the mass-spring fish around the spine; the second ring, of which the
    body frame is read, around the centre. Those before and behind it ride on the wings.
    """
    c = plan.centre
    stations = np.array([0.0, c / 2, c, *np.linspace(c, 1.0, 5)[1:]])
    if plan.wings:
        front, rear = plan.wings.chord
        stations[1], stations[3] = (front + c) / 2, (c + rear) / 2
        stations[3:] = np.linspace(stations[3], 1.0, 4)
    at = stations[1:6]
    tall = RING_SHARE * 0.5 * (along(surface.back, at) - along(surface.belly, at))
    middle = 0.5 * (along(surface.back, at) + along(surface.belly, at))
    wide = RING_SHARE * along(surface.width, at)
    if plan.wings:
        wide[1] = tall[1]
        wide[[0, 2]] = RING_ON_WING * half_span(surface)
    nodes = np.zeros((NODES, 3))
    nodes[:, 0] = np.repeat(stations, NODES_AT_STATION)
    nodes[0, 1] = middle[1]
    nodes[1:21, 1] = (middle[:, None] + np.outer(tall, RING_UP)).ravel()
    nodes[1:21, 2] = np.outer(wide, -RING_LEFT).ravel()
    last = np.array([1.0])
    nodes[21:, 1] = along(surface.back, last)[0], along(surface.belly, last)[0]
    return nodes
