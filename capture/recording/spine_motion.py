"""Record a spine-driven species: the same seven segments, kinematically (KS part II).

There is no water: the distance of a beat follows from the slip in the species' plan.
"""

from typing import NamedTuple

import numpy as np

from capture.recording.segment import make_segment
from subsea.biomechanics.body import NODES, RING_LEFT, RING_UP, Floats
from subsea.biomechanics.body_plan import NODES_AT_STATION
from subsea.core.arrays import Array
from subsea.fish.spine import MIDDLES, SpineGait, SpinePlan, bend_points, flap_wings, pose_spine
from subsea.fish.surface import SurfacePlan, along, fit_control_points, rest_surface
from subsea.repertoire import Segment

PATH_STEPS = 20000  # steps of the integration of a path
RING_SHARE = 0.7  # of the body's half-width and half-height
FRAME_NODES = [0, 5, 6, 7, 8]  # define the body frame
RING_ON_WING = 0.6  # half spans


class SpineMotion(NamedTuple):
    """The motion of a segment in world axes (x ahead, y up, z right), cm."""

    nodes: Floats  # (T + 1, 23, 3)
    points: Floats  # (T + 1, 426, 3) control points


class SwimPath(NamedTuple):
    """The path of the fish's centre: straight, with a bend between two distances."""

    length: float  # body lengths
    bend: tuple[float, float]  # body lengths from the start
    turn: float  # rad, left positive
    circular: bool  # an arc that also continues before and after; otherwise eased in and out

    def heading(self, at: Array) -> Array:
        """Direction in rad at the distances `at`, body lengths."""
        share = (at - self.bend[0]) / (self.bend[1] - self.bend[0])
        if not self.circular:
            share = np.clip(share, 0.0, 1.0)
            share = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        return np.asarray(self.turn * share)


def record_spine_segment(plan: SpinePlan, surface: SurfacePlan, name: str) -> Segment:
    """Record the segment ``name`` with control points: 23 nodes are too few for eels and rays."""
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
    """Compute all frames of a segment."""
    gait, beats, path = gait_and_path(plan, name)
    beat = np.linspace(0.0, beats, beats * gait.ticks_per_beat + 1)
    travelled = beat * plan.stride(gait)
    heading = path.heading(travelled)
    # A right turn is the mirror image of a left one: its beat begins half a beat later.
    side = 0.5 if path.turn < 0 else 0.0
    around = path.heading(travelled[:, None] + plan.centre - MIDDLES) - heading[:, None]
    spine = pose_spine(plan, beat + side, gait.amplitude, around, unit_mass(surface))
    rest = np.concatenate([rest_nodes(plan, surface), rest_surface(surface)])
    if plan.wings:
        body = flap_wings(plan.wings, rest, half_span(surface), beat, gait.amplitude)
    else:
        body = rest
    moved = roll(bend_points(spine, body), bank_angle(plan, path, travelled))
    # The body frame follows the path without sway and bank, so that playback can steer it.
    moved[:, FRAME_NODES] = (plan.centre, 0.0, 0.0) + rest[FRAME_NODES] * (-1, 1, 1)
    c, s = np.cos(heading)[:, None], np.sin(heading)[:, None]
    ahead, up, right = np.moveaxis(moved, -1, 0)
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
    return SpineMotion(
        world[:, :NODES], np.asarray(fit_control_points(world[:, NODES:]), np.float64)
    )


def gait_and_path(plan: SpinePlan, name: str) -> tuple[SpineGait, int, SwimPath]:
    """SpineGait, number of beats and path of a segment such as ``turn_left_gradual``."""
    kind, _, grade = name.rpartition("_")
    if kind == "swim":
        gait = {"slow": plan.slow, "medium": plan.medium, "fast": plan.fast}[grade]
        length = plan.stride(gait)
        return gait, 1, SwimPath(length, (0.0, length), 0.0, True)
    side = 1.0 if kind == "turn_left" else -1.0
    length = plan.stride(plan.medium)
    if grade == "gradual":
        turn = np.radians(plan.turn.gradual)
        return plan.medium, 1, SwimPath(length, (0.0, length), side * turn, True)
    # The snout enters the bend at the start, and the tail leaves it at the end.
    length *= plan.turn.sharp_beats
    bend = plan.centre, length - (1.0 - plan.centre)
    turn = float(np.radians(plan.turn.sharp))
    return plan.medium, plan.turn.sharp_beats, SwimPath(length, bend, side * turn, False)


def path_points(path: SwimPath, travelled: Array) -> Array:
    """Positions (T, 2) of the fish's centre, (ahead, left) of the start, body lengths."""
    at = np.linspace(0.0, path.length, PATH_STEPS + 1)
    heading = path.heading(0.5 * (at[1:] + at[:-1]))
    step = path.length / PATH_STEPS
    x, y = (np.concatenate([[0.0], np.cumsum(step * f(heading))]) for f in (np.cos, np.sin))
    return np.stack([np.interp(travelled, at, x), np.interp(travelled, at, y)], axis=-1)


def bank_angle(plan: SpinePlan, path: SwimPath, travelled: Array) -> Array:
    """Bank angle on the path, rad, left side down positive, proportional to the curvature.

    `bank` is reached at the greatest curvature of a sharp turn.
    """
    _, _, sharp = gait_and_path(plan, "turn_left_sharp")
    step = 1e-4
    most = sharp.turn / (sharp.bend[1] - sharp.bend[0]) * 15.0 / 8.0  # of the quintic
    curvature = (path.heading(travelled + step) - path.heading(travelled - step)) / (2.0 * step)
    return np.asarray(np.radians(plan.turn.bank) * np.clip(curvature / most, -1.0, 1.0))


def roll(points: Array, angle: Array) -> Array:
    """Points (T, p, 3) in path axes, rotated about the forward axis by `angle` (T,), rad."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    ahead, up, right = np.moveaxis(points, -1, 0)
    return np.stack([ahead, c * up + s * right, c * right - s * up], axis=-1)


def unit_mass(surface: SurfacePlan) -> Array:
    """Relative mass (n,) of each unit of the spine: its cross-section."""
    back, belly = along(surface.back, MIDDLES), along(surface.belly, MIDDLES)
    return np.asarray(along(surface.width, MIDDLES) * (back - belly))


def half_span(surface: SurfacePlan) -> float:
    """Distance from the spine to the tip of a wing, body lengths."""
    return surface.wing.span if surface.wing else max(width for _, width in surface.width)


def nodes_at_rest(plan: SpinePlan, surface: SurfacePlan) -> Array:
    """The 23 nodes (23, 3) of the fish at rest in body axes, cm."""
    nodes = rest_nodes(plan, surface)
    nodes[:, 0] = plan.centre - nodes[:, 0]
    nodes[:, 1] -= nodes[5:9, 1].mean()
    return nodes * plan.length


def rest_nodes(plan: SpinePlan, surface: SurfacePlan) -> Array:
    """The nodes (23, 3) at rest, (distance behind the snout, up, right), body lengths.

    They are in rings around the spine, in the order of the mass-spring fish. The second ring is at
    the centre; on rays its neighbours lie on the wings.
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
