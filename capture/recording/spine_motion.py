"""Move a spine-driven fish along its path, kinematically (KS part II).

Stride and recoil of a beat follow from the water; with a slip in the plan there is neither water
nor recoil.
"""

import math
from typing import NamedTuple

import numpy as np

from capture.recording.spine_water import coast, recoil_of, stride_of, unit_mass
from subsea.base.arrays import Array
from subsea.biomechanics.body import NODES, RING_LEFT, RING_UP, Floats
from subsea.biomechanics.body_plan import NODES_AT_STATION
from subsea.fish.spine import (
    MIDDLES,
    RUN_IN,
    SpineGait,
    SpinePlan,
    bend_points,
    flap_wings,
    keep_height,
    pose_spine,
)
from subsea.fish.surface import SurfacePlan, along, fit_control_points, rest_surface

PATH_STEPS = 20000  # steps of the integration of a path
RING_SHARE = 0.7  # of the body's half-width and half-height
FRAME_NODES = [0, 5, 6, 7, 8]  # define the body frame
RING_ON_WING = 0.9  # half spans: transitions match the motion of nodes, so of tips
PEAK = 15.0 / 8.0  # greatest over mean curvature of a bend
GLIDE_TURN = np.radians(90.0)
MOST_LEAN = 0.75  # sine of the bank
LEAST_RADIUS = 0.6  # disc widths, of a gliding ray; mantas turn within 2 m (Fish et al. 2018)


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


class Travel(NamedTuple):
    """Swimming along a path, at T + 1 ticks."""

    path: SwimPath
    beat: Array  # beats since the start
    amplitude: Array  # of the swing
    travelled: Array  # body lengths


class Stroke(NamedTuple):
    """The beat of a gait at T times."""

    gait: SpineGait
    beat: Array  # (T,) beats since the start
    amplitude: Array  # (T,) of the swing
    side: float = 0.0  # beats by which the spine, but not the wings, is ahead


def spine_motion(
    plan: SpinePlan, surface: SurfacePlan, name: str, speed: float | None = None
) -> SpineMotion:
    """Compute all frames of a segment that follows a path.

    ``speed``, body lengths per tick, is that at which a glide begins, by default that of the rules.
    """
    gait, travel = gait_and_travel(plan, surface, name, speed)
    path, travelled = travel.path, travel.travelled
    heading = path.heading(travelled)
    # A right turn is the mirror image of a left one: its beat begins half a beat later.
    stroke = Stroke(gait, travel.beat, travel.amplitude, 0.5 if path.turn < 0 else 0.0)
    around = path.heading(travelled[:, None] + plan.centre - MIDDLES) - heading[:, None]
    moved = pose_surface(plan, surface, stroke, around)
    moved = roll(moved, bank_angle(plan, surface, path, travelled))
    frame = np.concatenate([path_points(path, travelled), heading[:, None]], axis=1)
    return in_world(plan, surface, moved, frame)


def pose_surface(plan: SpinePlan, surface: SurfacePlan, stroke: Stroke, around: Array) -> Array:
    """Nodes and points (T, 449, 3) of a fish, with its recoil; (ahead, up, right), body lengths.

    ``around`` (T, n) are the directions of its path at the units, relative to that at its centre.
    """
    amplitude = stroke.amplitude[:, None]
    rest = np.concatenate([rest_nodes(plan, surface), rest_surface(surface)])
    body, beat = rest, stroke.beat
    if plan.wings:
        body = flap_wings(plan.wings, rest, half_span(surface), beat, amplitude)
        if stroke.gait.slip is not None:
            body = keep_height(body, rest)
    spine = pose_spine(plan, beat + stroke.side, amplitude, around, unit_mass(surface))
    recoil = recoil_of(plan, surface, stroke.gait, beat if plan.wings else beat + stroke.side)
    recoil = recoil * amplitude / max(stroke.gait.amplitude, 1e-9)
    return shake(bend_points(spine, body), recoil, bool(plan.wings))


def shake(points: Array, recoil: Array, up: bool) -> Array:
    """Turn and shift points (T, p, 3) by the recoil (T, 3), upward or to the left."""
    axis, sign = (1, 1.0) if up else (2, -1.0)
    ahead, aside = points[..., 0], sign * points[..., axis]
    c, s = np.cos(recoil[:, 2:]), np.sin(recoil[:, 2:])
    out = points.copy()
    out[..., 0] = c * ahead - s * aside + recoil[:, :1]
    out[..., axis] = sign * (s * ahead + c * aside + recoil[:, 1:2])
    return out


def in_world(plan: SpinePlan, surface: SurfacePlan, moved: Array, frame: Array) -> SpineMotion:
    """A motion from points in axes of frames (T, 3): ahead and left in body lengths, heading."""
    # The body frame has neither recoil nor bank, so that playback can steer it.
    rest = rest_nodes(plan, surface)[FRAME_NODES]
    moved[:, FRAME_NODES] = (plan.centre, 0.0, 0.0) + rest * (-1, 1, 1)
    x, y, heading = frame.T[..., None]
    c, s = np.cos(heading), np.sin(heading)
    ahead, up, right = np.moveaxis(moved, -1, 0)
    world = np.stack([x + c * ahead + s * right, up, -y - s * ahead + c * right], axis=-1)
    world *= plan.length
    return SpineMotion(
        world[:, :NODES], np.asarray(fit_control_points(world[:, NODES:]), np.float64)
    )


def gait_and_travel(
    plan: SpinePlan, surface: SurfacePlan, name: str, speed: float | None = None
) -> tuple[SpineGait, Travel]:
    """Gait and travel of a segment such as ``turn_left_gradual``; ``speed`` of a glide's start."""
    kind, _, grade = name.rpartition("_")
    gait = getattr(plan, grade) if kind == "swim" else plan.medium
    stride, ticks = stride_of(plan, surface, gait), gait.ticks_per_beat
    side = 1.0 if kind == "turn_left" else -1.0
    if grade == "glide":
        return gait, glide_travel(plan, surface, side * GLIDE_TURN, speed or stride / ticks)
    if grade == "sharp":
        beats = max(plan.turn.sharp_beats, math.ceil((1.0 + RUN_IN) / stride))
        path = through_bend(plan, beats * stride, side * np.radians(plan.turn.sharp))
    else:
        beats = 1
        turn = side * np.radians(plan.turn.gradual) if grade == "gradual" else 0.0
        path = SwimPath(stride, (0.0, stride), turn, True)
    beat = np.linspace(0.0, beats, beats * ticks + 1)
    return gait, Travel(path, beat, np.full(len(beat), gait.amplitude), beat * stride)


def through_bend(plan: SpinePlan, length: float, turn: float) -> SwimPath:
    """A path with a bend that the snout enters at the start and the tail leaves at the end."""
    return SwimPath(length, (plan.centre, length - (1.0 - plan.centre)), turn, False)


def glide_travel(plan: SpinePlan, surface: SurfacePlan, turn: float, speed: float) -> Travel:
    """A turn of a ray that holds its wings still and slows down, from ``speed`` per tick."""
    bend = abs(turn) * PEAK * LEAST_RADIUS * 2.0 * half_span(surface)
    travelled = coast(plan, surface, speed, 1.0 + bend)
    still = np.zeros(len(travelled))
    return Travel(through_bend(plan, float(travelled[-1]), turn), still, still, travelled)


def path_points(path: SwimPath, travelled: Array) -> Array:
    """Positions (T, 2) of the fish's centre, (ahead, left) of the start, body lengths."""
    at = np.linspace(0.0, path.length, PATH_STEPS + 1)
    heading = path.heading(0.5 * (at[1:] + at[:-1]))
    step = path.length / PATH_STEPS
    x, y = (np.concatenate([[0.0], np.cumsum(step * f(heading))]) for f in (np.cos, np.sin))
    return np.stack([np.interp(travelled, at, x), np.interp(travelled, at, y)], axis=-1)


def bank_angle(plan: SpinePlan, surface: SurfacePlan, path: SwimPath, travelled: Array) -> Array:
    """Bank angle on the path, rad, left side down positive.

    The lift of banked wings turns a ray, so the sine of the bank is proportional to the curvature
    at any speed. `bank` belongs to the greatest curvature of a sharp turn.
    """
    sharp = gait_and_travel(plan, surface, "turn_left_sharp")[1].path
    step = 1e-4
    most = PEAK * sharp.turn / (sharp.bend[1] - sharp.bend[0])
    curvature = (path.heading(travelled + step) - path.heading(travelled - step)) / (2.0 * step)
    lean = np.sin(np.radians(plan.turn.bank)) * curvature / most
    return np.asarray(np.arcsin(np.clip(lean, -MOST_LEAN, MOST_LEAN)))


def roll(points: Array, angle: Array) -> Array:
    """Points (T, p, 3) in path axes, rotated about the forward axis by `angle` (T,), rad."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    ahead, up, right = np.moveaxis(points, -1, 0)
    return np.stack([ahead, c * up + s * right, c * right - s * up], axis=-1)


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
