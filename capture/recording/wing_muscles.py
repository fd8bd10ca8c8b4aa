"""Move a ray by its muscles: a simulated disc in the water (biomechanics/disc.py).

A beat is a wave of contractions that runs to the rear and to the tips of the wings, on back and
belly in turn. In a turn the outer wing beats stronger than the inner one, and the ray leans into
the turn. The difference is searched, such that the ray turns as far as asked. Right turns mirror
left ones. A ray that glides holds its wings still: its path follows rules (spine_motion.py).

The path of the fish is the mean of its motion over a beat. Its tail is drawn along behind the disc.
"""

from collections.abc import Callable
from functools import cache, lru_cache
from typing import NamedTuple

import msgspec
import numpy as np

from capture.recording.spine_manoeuvre import ease, even_path, search_bend
from capture.recording.spine_motion import SpineMotion, in_world
from capture.recording.wing_surface import COLUMNS, DiscSurface, disc_outline, draw_tail, middles
from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.biomechanics.disc import (
    DiscState,
    build_disc,
    copy_disc,
    disc_at_rest,
    flap,
    kept_shape,
)
from subsea.biomechanics.prescribed_wave import CROSS_DRAG, SKIN_DRAG
from subsea.biomechanics.solver import STEPS_PER_TICK, TIME_UNIT_S
from subsea.fish.spine import SpineGait, SpinePlan
from subsea.fish.surface import SurfacePlan

CLOSED = 1e-8  # body lengths, of a steady beat
MOST_BEATS = 400
START_SPEED = 0.5  # body lengths per second, before the first beat
STRENGTH_STEP, MOST_STRENGTH = 0.1, 1.2  # of a turn, in its search
OUTER, INNER = 0.8, 0.3  # share by which the wings beat stronger and weaker, per strength
BRAKE = 5.0  # waves that the inner wing has more, per body length and strength
RECOVERY = 0.4  # beats at the end of a sharp turn in which the wings beat alike
FIRM, FREE = 0.2, 0.6  # half spans: roots beat alike in a turn, from the second on wings differ
TAIL_BEATS = 4  # after which the tail follows evenly


class RayPath(NamedTuple):
    """The motion of a segment, in body lengths and radians."""

    disc: Array  # (T + 1, J, I, 3) ahead, up, right in the world
    path: Array  # (T + 1,) of the centre of mass, ahead + i left, without the recoil of the beat
    heading: Array  # (T + 1,) the same
    trunk: Array  # (before + T + 1, 2, 3) its rear and front edge, from some beats before on


class Swum(NamedTuple):
    """The motion of the disc, in body lengths and radians."""

    disc: Array  # (T + 1, J, I, 3) ahead, up, right in the world
    middle: Array  # (T + 1,) centre of mass, ahead + i left
    heading: Array  # (T + 1,) of the trunk
    height: Array  # (T + 1,) of the centre of mass


class RayBeat(NamedTuple):
    """One beat of a steady swim."""

    state: DiscState  # at the end, cm
    swum: Swum
    motion: RayPath


def wing_motion(plan: SpinePlan, surface: SurfacePlan, name: str) -> SpineMotion:
    """Simulate all frames of a segment; UserError where the body loses its shape."""
    ray = ray_of(plan, surface)
    swum = ray.swim(name.replace("_right_", "_left_"))
    if "right" in name:
        swum = _mirrored(swum)
    ahead = np.exp(1j * swum.heading)
    centre = swum.path + ray.reach * ahead
    tail = draw_tail(swum.trunk, ray.surface.joint)[-len(centre) :]
    moved = ray.surface.pose(*(_seen(places, centre, ahead) for places in (swum.disc, tail)))
    frame = np.stack([centre.real, centre.imag, swum.heading], axis=1)
    return in_world(plan, surface, moved, frame)


def _mirrored(swum: RayPath) -> RayPath:
    other_side = (1.0, 1.0, -1.0)
    return RayPath(
        swum.disc[:, ::-1] * other_side,
        swum.path.conj(),
        -swum.heading,
        swum.trunk * other_side,
    )


def _seen(places: Array, centre: Array, ahead: Array) -> Array:
    """Places (T, …, 3) of the world in axes of the path."""
    many = (len(centre),) + (1,) * (places.ndim - 2)
    flat = (places[..., 0] - 1j * places[..., 2] - centre.reshape(many)) / ahead.reshape(many)
    return np.stack([flat.real, places[..., 1], -flat.imag], axis=-1)


def ray_of(plan: SpinePlan, surface: SurfacePlan) -> "Ray":
    """The ray of these plans, with what it has swum before."""
    return _ray(msgspec.json.encode(plan), msgspec.json.encode(surface))


@lru_cache(maxsize=4)
def _ray(plan: bytes, surface: bytes) -> "Ray":
    return Ray(
        msgspec.json.decode(plan, type=SpinePlan), msgspec.json.decode(surface, type=SurfacePlan)
    )


class Ray:
    """A disc that swims by the muscles of a plan."""

    def __init__(self, plan: SpinePlan, surface: SurfacePlan) -> None:
        """Build the body; ValueError without muscles in the wings."""
        if plan.wings is None or plan.wings.muscles is None:
            raise ValueError("the wings have no muscles")
        self.plan, self._muscles = plan, plan.wings.muscles
        outline = disc_outline(surface, plan.length)
        self.disc = build_disc(
            outline, self._muscles.stiffness, self._muscles.viscosity, CROSS_DRAG, SKIN_DRAG
        )
        self.surface = DiscSurface(plan, surface, self.disc)
        self._mass = self.disc.mass / self.disc.mass.sum()
        self.reach = -float(self._mass @ self.disc.rest[:, 0]) / plan.length - plan.centre
        still = middles(self.disc, self.disc.rest)
        self._between = 0.5 * (still[1:] + still[:-1]) / plan.length  # (J - 1, I, 3)
        self._share = self._between[:, 0, 2] / still[-1, 0, 2] * COLUMNS[-1] * plan.length
        self._per_tick = STEPS_PER_TICK * self.disc.substeps
        self._beats: dict[tuple[SpineGait, float, float], RayBeat] = {}
        self._paths: dict[str, RayPath] = {}

    def swim(self, name: str) -> RayPath:
        """Swim a segment straight on or to the left, once for both sides."""
        if name not in self._paths:
            self._paths[name] = self._path(name)
        return self._paths[name]

    def _path(self, name: str) -> RayPath:
        kind, _, grade = name.rpartition("_")
        turn = self.plan.turn
        if kind == "swim":
            return self.steady(getattr(self.plan, grade)).motion
        lean = float(np.sin(np.radians(turn.bank)))
        if grade == "gradual":
            lean *= turn.gradual * turn.sharp_beats / (2.0 * turn.sharp)
            return self._turn(
                lambda strength: self.steady(self.plan.medium, strength, lean).motion, turn.gradual
            )
        return self._turn(lambda strength: self.sharp(strength, lean), turn.sharp)

    def pace(self, gait: SpineGait) -> float:
        """Body lengths a tick in steady swimming."""
        path = self.steady(gait).motion.path
        return float(abs(path[-1] - path[0])) / gait.ticks_per_beat

    def steady(self, gait: SpineGait, strength: float = 0.0, lean: float = 0.0) -> RayBeat:
        """Swim until the beat repeats, straight on or with a turn and a lean to the left."""
        if (gait, strength, lean) not in self._beats:
            self._beats[gait, strength, lean] = self._settle(gait, strength, lean)
        return self._beats[gait, strength, lean]

    def _settle(self, gait: SpineGait, strength: float, lean: float) -> RayBeat:
        ticks = np.arange(gait.ticks_per_beat * self._per_tick) / self._per_tick
        beat = ticks / gait.ticks_per_beat
        raising = self._raised(gait, beat, np.full(len(beat), strength))
        bank = np.full(len(beat), lean)
        if strength or lean:
            state = copy_disc(self.steady(gait).state)
        else:
            state = disc_at_rest(self.disc, START_SPEED * self.plan.length * TIME_UNIT_S)
            self._simulate(state, ease(beat)[:, None, None] * raising, bank)
        for _ in range(MOST_BEATS):
            swum = self._simulate(state, raising, bank)
            shapes = _seen(swum.disc, swum.middle, np.exp(1j * swum.heading))[[0, -1]]
            if abs(shapes[1] - shapes[0]).max() <= CLOSED:
                return RayBeat(state, swum, _even(swum))
        raise UserError(f"the body does not swim steadily after {MOST_BEATS} beats")

    def sharp(self, strength: float, lean: float) -> RayPath:
        """Swim from a steady beat on through a turn, and recover from it."""
        gait, beats = self.plan.medium, self.plan.turn.sharp_beats
        beat = gait.ticks_per_beat
        # A beat more, for means over a beat.
        ticks = np.arange((beats + 1) * beat * self._per_tick) / self._per_tick
        bent = np.clip(ticks / ((beats - RECOVERY) * beat), 0.0, 1.0)
        profile = np.sin(np.pi * bent) ** 2
        raising = self._raised(gait, ticks / beat, strength * profile)
        steady = self.steady(gait)
        swum = self._simulate(copy_disc(steady.state), raising, lean * profile)
        whole = Swum(*(np.concatenate([a[:-1], b]) for a, b in zip(steady.swum, swum, strict=True)))
        part = slice(beat, beat * (beats + 1) + 1)
        path, heading, height = (
            _beat_mean(values, beat)[part] for values in (whole.middle, whole.heading, whole.height)
        )
        disc = whole.disc[part] - height[:, None, None, None] * (0.0, 1.0, 0.0)
        trunk = np.concatenate([steady.motion.trunk, _edges(disc)[1:]])
        return RayPath(disc, path, heading, trunk)

    def glide(self, speed: float, ticks: int) -> Array:
        """Ways (ticks + 1,), cm, of the straight body that begins at ``speed`` cm/tu."""
        steps = ticks * self._per_tick
        still = np.zeros((steps, len(self._share), self.disc.rows))
        swum = self._simulate(disc_at_rest(self.disc, speed), still, np.zeros(steps))
        return swum.middle.real * self.plan.length

    def _simulate(self, state: DiscState, raising: Array, bank: Array) -> "Swum":
        start = state.x[None].copy()
        frames = np.concatenate([start, flap(self.disc, state, raising, bank)])
        if not kept_shape(state):
            raise UserError("the body of the ray loses its shape")
        frames = frames / self.plan.length
        mean = np.einsum("n,tnc->tc", self._mass, frames)
        disc = middles(self.disc, frames)
        trunk = disc[:, disc.shape[1] // 2]
        axis = trunk[:, 0] - trunk[:, -1]
        heading = np.unwrap(np.angle(axis[:, 0] - 1j * axis[:, 2]))
        return Swum(disc, mean[:, 0] - 1j * mean[:, 2], heading, mean[:, 1])

    @staticmethod
    def _turn(swim: Callable[[float], RayPath], degrees: float) -> RayPath:
        """Find the strength with which the fish turns by ``degrees``, and swim with it."""
        swim, turn = cache(swim), float(np.radians(degrees))

        def turned(strength: float) -> float:
            heading = swim(strength).heading
            return float(heading[-1] - heading[0])

        least, most = 0.0, STRENGTH_STEP
        while most < MOST_STRENGTH and turned(most) < turn:
            least, most = most, most + STRENGTH_STEP
        try:
            strength = search_bend(turned, turn, least, most)
        except ValueError:
            raise UserError(
                f"its wings cannot turn the ray by {degrees:g}°; give the medium swim more "
                "contraction, or the turn more time"
            ) from None
        return swim(strength)

    def _raised(self, gait: SpineGait, beat: Array, strength: Array) -> Array:
        """Contractions (T, J - 1, I) of the muscles of the back, at times ``beat`` (T,).

        ``strength`` (T,) is that of a turn to the left. Its outer wing beats stronger. Its inner
        wing beats weaker, and its wave runs slower than the fish: that brakes.
        """
        root, tip = self._muscles.contraction
        reach = np.abs(self._share)[:, None]
        outer = self._share[:, None] > 0.0
        differ = np.clip((reach - FIRM) / (FREE - FIRM), 0.0, 1.0)
        turn = strength[:, None, None]
        size = gait.contraction * (root + (tip - root) * reach)
        size = size * (1.0 + turn * differ * np.where(outer, OUTER, -INNER))
        behind = -self._between[..., 0] - self.plan.centre
        waves = 1.0 / self._muscles.wavelength + turn * np.where(outer, 0.0, BRAKE)
        late = waves * behind + self._muscles.tip_lag * reach
        return np.asarray(size * np.sin(2.0 * np.pi * (beat[:, None, None] - late)))


def _even(swum: Swum) -> RayPath:
    """Part a steady beat into an even path and the motion about it."""
    path, heading = even_path(swum.middle, swum.heading)
    disc = swum.disc - swum.height[:-1].mean() * np.array([0.0, 1.0, 0.0])
    trunk = _edges(disc)
    flat = trunk[..., 0] - 1j * trunk[..., 2]
    spin = np.exp(1j * (heading[0] - heading[-1]))
    parts = [trunk]
    for _ in range(TAIL_BEATS):  # back in time, beat by beat
        flat = path[0] + (flat - path[-1]) * spin
        parts.append(np.stack([flat.real, trunk[..., 1], -flat.imag], axis=-1)[:-1])
    return RayPath(disc, path, heading, np.concatenate(parts[::-1]))


def _edges(disc: Array) -> Array:
    """Middles (T, 2, 3) of the rear and the front edge of the trunk."""
    return disc[:, disc.shape[1] // 2, [-1, 0]]


def _beat_mean(values: Array, beat: int) -> Array:
    """Mean of values (T,) over a beat around each tick; wrong within half a beat of the ends."""
    ticks = np.arange(len(values))
    total = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))])
    late, early = (np.interp(ticks + side * beat, ticks, total) for side in (0.5, -0.5))
    return np.asarray((late - early) / beat)
