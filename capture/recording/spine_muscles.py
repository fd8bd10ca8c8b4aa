"""Move an eel by its muscles: a simulated long body in the water (biomechanics/long_body.py).

A beat is a wave of contractions that runs to the tail, on both sides in turn. A constant bend on
one side makes a gradual turn. In an escape and in other turns a bend begins behind the head and
runs to the tail. Its size is searched, such that the fish turns as far as asked. Right turns
mirror left ones.

The path of the fish is that of its straightened body, without the recoil of its beat.
"""

from collections.abc import Callable
from functools import cache, lru_cache
from typing import NamedTuple

import msgspec
import numpy as np

from capture.recording.spine_manoeuvre import (
    AT_ONCE,
    LATE,
    Manoeuvre,
    ease,
    even_path,
    manoeuvre,
    search_bend,
)
from capture.recording.spine_motion import SpineMotion, in_world, rest_nodes
from capture.recording.spine_water import fin_height
from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.biomechanics.long_body import (
    LongBody,
    Outline,
    at_rest,
    bend,
    build_long_body,
    midline,
)
from subsea.biomechanics.prescribed_wave import CROSS_DRAG, SKIN_DRAG
from subsea.biomechanics.simulation import BodyState, copy_state, is_sound
from subsea.biomechanics.solver import STEPS_PER_TICK, TICK_TU
from subsea.fish.skinning import hermite
from subsea.fish.spine import JOINTS, SpineGait, SpineMuscles, SpinePlan, Spines, bend_points
from subsea.fish.surface import SurfacePlan, along, rest_surface

ENDS = 0.03  # distance of the first and last ring from the ends, body lengths
CLOSED = 1e-8  # body lengths, of a steady beat
MOST_BEATS = 200
MOST_BEND, BEND_STEP = 0.4, 0.04  # contraction: the largest of a bend, and steps of its search
EVEN_TURN = 1.1, 0.8  # time of the recorded turn over that of the bend: of free and sharp turns
SHARP_BEND = 0.6  # share of the time of a sharp turn in which the body is bent


class SteadyBeat(NamedTuple):
    """One beat of a steady swim, in body lengths and radians."""

    state: BodyState  # at the end
    line: Array  # (T + 1, stations) midline, ahead + i left, in the world
    path: Array  # (T + 1,) of the centre of mass, the same, without its recoil
    heading: Array  # (T + 1,) the same
    recoil: Array  # (T + 1,) of the centre of mass, in axes of the path
    yaw: Array  # (T + 1,) the same of the heading


class EelPath(NamedTuple):
    """The motion of a segment, in body lengths and radians."""

    line: Array  # (T + 1, stations) midline, ahead + i left, in the world
    path: Array  # (T + 1,) of the centre of mass, without the recoil of the beat
    heading: Array  # (T + 1,) the same


def muscle_motion(plan: SpinePlan, surface: SurfacePlan, name: str) -> SpineMotion:
    """Simulate all frames of a segment; UserError where the body loses its shape."""
    eel = eel_of(plan, surface)
    path = eel.swim(name.replace("_right_", "_left_"))
    if "right" in name:
        path = EelPath(path.line.conj(), path.path.conj(), -path.heading)
    ahead = np.exp(1j * path.heading)
    centre = path.path + eel.reach * ahead
    spine = eel.spine((path.line - centre[:, None]) / ahead[:, None])
    rest = np.concatenate([rest_nodes(plan, surface), rest_surface(surface)])
    frame = np.stack([centre.real, centre.imag, path.heading], axis=1)
    return in_world(plan, surface, bend_points(spine, rest), frame)


def eel_of(plan: SpinePlan, surface: SurfacePlan) -> "Eel":
    """The eel of these plans, with what it has swum before."""
    return _eel(msgspec.json.encode(plan), msgspec.json.encode(surface))


@lru_cache(maxsize=4)
def _eel(plan: bytes, surface: bytes) -> "Eel":
    return Eel(
        msgspec.json.decode(plan, type=SpinePlan), msgspec.json.decode(surface, type=SurfacePlan)
    )


class Eel:
    """A long body that swims by the muscles of a plan."""

    def __init__(self, plan: SpinePlan, surface: SurfacePlan) -> None:
        """Build the body; ValueError without muscles."""
        if plan.muscles is None:
            raise ValueError("the spine has no muscles")
        self.plan, self._muscles = plan, plan.muscles
        self._at, self.long = _body(plan, plan.muscles, surface)
        mass = _at_stations(self.long.body.mass)
        self._mass = mass / mass.sum()
        self._arm = self._mass @ self._at - self._at  # ahead of the centre of mass
        self.reach = self._mass @ self._at - plan.centre
        self._places = 0.5 * (self._at[1:-2] + self._at[2:-1])  # of the segments
        self._per_tick = STEPS_PER_TICK * self.long.substeps
        self._beats: dict[tuple[SpineGait, float], SteadyBeat] = {}
        self._paths: dict[str, EelPath] = {}

    def swim(self, name: str) -> EelPath:
        """Swim a segment straight on or to the left, once for both sides."""
        if name not in self._paths:
            self._paths[name] = self._path(name)
        return self._paths[name]

    def _path(self, name: str) -> EelPath:
        kind, _, grade = name.rpartition("_")
        if kind == "swim" and grade in ("slow", "medium", "fast", "burst"):
            return self._cycle(getattr(self.plan, grade))
        if grade == "gradual":
            turn = float(np.radians(self.plan.turn.gradual))
            return self._turn(lambda bias: self._cycle(self.plan.medium, bias), turn)
        what = self._sharp() if grade == "sharp" else manoeuvre(self.plan, name, self.pace)
        path = self._turn(lambda size: self.move(what, size), what.turn)
        # The heading of a body in a C changes abruptly, and playback needs an even one.
        ticks = min(EVEN_TURN[grade == "sharp"] * what.bend, what.ticks)
        even = what.turn * ease(np.arange(what.ticks + 1) / ticks)
        return path._replace(heading=path.heading[0] + even)

    def pace(self, gait: SpineGait) -> float:
        """Body lengths a tick in steady swimming."""
        path = self.steady(gait).path
        return float(abs(path[-1] - path[0])) / gait.ticks_per_beat

    def steady(self, gait: SpineGait, bias: float = 0.0) -> SteadyBeat:
        """Swim from rest until the beat repeats; ``bias`` contracts the left side all the time."""
        if (gait, bias) not in self._beats:
            self._beats[gait, bias] = self._settle(gait, bias)
        return self._beats[gait, bias]

    def glide(self, speed: float, ticks: int) -> Array:
        """Ways (ticks + 1,), cm, of the straight body that begins at ``speed`` cm/tu."""
        state = at_rest(self.long)
        state.v[:, 0] = speed
        still = np.zeros((ticks * self._per_tick, self.long.segments))
        return self._simulate(state, still)[1].real * self.plan.length

    def _settle(self, gait: SpineGait, bias: float) -> SteadyBeat:
        ticks = np.arange(gait.ticks_per_beat * self._per_tick) / self._per_tick
        beat = ticks / gait.ticks_per_beat
        full = self._wave(gait, beat) + bias
        state = at_rest(self.long)
        bend(self.long, state, ease(beat)[:, None] * full)
        for _ in range(MOST_BEATS):
            line, middle, heading = self._simulate(state, full)
            shape = (line[[0, -1]] - middle[[0, -1], None]) / np.exp(1j * heading[[0, -1], None])
            if abs(shape[1] - shape[0]).max() <= CLOSED:
                return _smooth(state, line, middle, heading)
        raise UserError(f"the body does not swim steadily after {MOST_BEATS} beats")

    def move(self, what: Manoeuvre, size: float) -> EelPath:
        """Swim a manoeuvre whose bend contracts the left side by ``size``."""
        gait = what.gait
        ticks = np.arange(what.ticks * self._per_tick + 1) / self._per_tick
        beat, share = ticks / gait.ticks_per_beat, ticks / what.ticks
        eased = ease((share - what.beats_from) / abs(what.easing))
        amplitude = eased if what.easing > 0 else 1.0 - eased
        after = LATE * np.maximum(self._places - AT_ONCE, 0.0) / (1.0 - AT_ONCE)
        late = (ticks[:, None] / what.bend - after) / (1.0 - LATE)
        contraction = size * np.sin(np.pi * np.clip(late, 0.0, 1.0)) ** 2
        contraction += amplitude[:, None] * self._wave(gait, beat)
        if amplitude[0] > 0.0:
            state = copy_state(self.steady(gait).state)
        else:
            state = at_rest(self.long)
            state.v[:, 0] = what.speed * self.plan.length / TICK_TU
        line, middle, heading = self._simulate(state, contraction[:-1])
        steady = self.steady(gait)
        row, now = np.arange(what.ticks + 1) % gait.ticks_per_beat, amplitude[:: self._per_tick]
        heading = heading - now * steady.yaw[row]
        return EelPath(line, middle - now * steady.recoil[row] * np.exp(1j * heading), heading)

    def _cycle(self, gait: SpineGait, bias: float = 0.0) -> EelPath:
        return EelPath(*self.steady(gait, bias)[1:4])

    @staticmethod
    def _turn(swim: Callable[[float], EelPath], turn: float) -> EelPath:
        """Find the contraction with which the fish turns by ``turn`` rad, and swim with it."""
        swim = cache(swim)

        def turned(size: float) -> float:
            heading = swim(size).heading
            return float(heading[-1] - heading[0])

        # Small steps first, as a strong bend tears the body.
        least, most = (0.0, BEND_STEP) if turn else (-BEND_STEP, BEND_STEP)
        while most < MOST_BEND and turned(most) < turn:
            least, most = most, most + BEND_STEP
        return swim(search_bend(turned, turn, least, most))

    def _sharp(self) -> Manoeuvre:
        turn, medium = self.plan.turn, self.plan.medium
        ticks = turn.sharp_beats * medium.ticks_per_beat
        angle = float(np.radians(turn.sharp))
        return Manoeuvre(ticks, medium, -2.0, 1.0, 0.0, angle, round(SHARP_BEND * ticks))

    def _wave(self, gait: SpineGait, beat: Array) -> Array:
        """Contractions (n, segments) on the left at times ``beat`` (n,)."""
        front, rear = self._muscles.contraction
        size = gait.contraction * (front + (rear - front) * self._places)
        phase = beat[:, None] - self._places / self._muscles.wavelength
        return np.asarray(size * np.sin(2.0 * np.pi * phase))

    def _simulate(self, state: BodyState, left: Array) -> tuple[Array, Array, Array]:
        """Midlines (T + 1, stations), and centre and heading of the body straightened."""
        start = state.x[None].copy()
        frames = np.concatenate([start, bend(self.long, state, left)])
        if not is_sound(state):
            raise UserError("the body of the eel loses its shape")
        middle = midline(frames) / self.plan.length
        line = middle[..., 0] - 1j * middle[..., 2]
        mean = line @ self._mass
        heading = np.unwrap(np.angle((line - mean[:, None]) @ (self._mass * self._arm)))
        return line, mean, heading

    def spine(self, line: Array) -> Spines:
        """The spine whose stations lie at ``line`` (T, stations), ahead + i left."""
        place = line @ hermite(-self._at, -JOINTS).T
        direction = np.unwrap(np.angle(place[:, :-1] - place[:, 1:]), axis=1)
        return Spines(np.stack([place.real, place.imag], axis=-1), direction)


def _body(plan: SpinePlan, muscles: SpineMuscles, surface: SurfacePlan) -> tuple[Array, LongBody]:
    """Stations in body lengths, and the body with the outline of a surface."""
    at = np.array([0.0, *np.linspace(ENDS, 1.0 - ENDS, muscles.rings), 1.0])
    length = plan.length
    tall = along(surface.back, at) - along(surface.belly, at)
    outline = Outline(
        at=at * length,
        half_width=along(surface.width, at) * length,
        half_height=0.5 * tall * length,
        height=fin_height(surface, at) * length,
    )
    return at, build_long_body(outline, muscles.stiffness, muscles.viscosity, CROSS_DRAG, SKIN_DRAG)


def _at_stations(values: Array) -> Array:
    """Sums (stations,) of values of nodes (n,)."""
    return np.array([values[0], *values[1:-2].reshape(-1, 4).sum(axis=1), values[-2:].sum()])


def _smooth(state: BodyState, line: Array, middle: Array, heading: Array) -> SteadyBeat:
    """Part the motion of a beat into an even path and the recoil from it."""
    path, course = even_path(middle, heading)
    recoil = (middle - path) / np.exp(1j * course)
    return SteadyBeat(state, line, path, course, recoil, heading - course)
