"""Speed and recoil of a spine-driven fish: its wave in the water of the elongated-body theory.

An eel is one strip of sections, each as tall as body and fins. A ray's wing is cut into strips
along the chord. Up to a place ξ behind its front edge a strip has the added mass of a plate,
½πρξ per chord and span, which amounts to ¼πρc² and sheds half of the steady lift behind: the limit
of thin-aerofoil theory for fast beats (Theodorsen's C = ½; eagle rays beat at reduced frequencies
above .5). Flow along the span and the ends of the wake are neglected.
"""

from functools import lru_cache

import msgspec
import numpy as np

from subsea.base.arrays import Array
from subsea.biomechanics.prescribed_wave import DENSITY, Beat, Strips, steady_beat, trailing
from subsea.biomechanics.solver import TICK_S
from subsea.fish.spine import MIDDLES, UNITS, SpineGait, SpinePlan, flap_wings, pose_spine
from subsea.fish.surface import FinPlan, SurfacePlan, along

TIMES = 96  # of a beat
UNITS_OF_SECTION = 4
STRIPS, SECTIONS = 10, 12  # of a wing
GLIDE_DRAG = 0.005  # of the wetted area of a still body: a turbulent plate at Re 1e6


def stride_of(plan: SpinePlan, surface: SurfacePlan, gait: SpineGait) -> float:
    """Body lengths in a beat: by the gait's slip, or by the water."""
    if gait.slip is not None:
        return gait.slip * plan.wavelength
    return swim_beat(plan, surface, gait).stride / plan.length


def recoil_of(plan: SpinePlan, surface: SurfacePlan, gait: SpineGait, beat: Array) -> Array:
    """Recoil (T, 3) of a gait at times ``beat`` (T,): body lengths ahead and aside, rad."""
    if gait.slip is not None:
        return np.zeros((len(beat), 3))
    recoil = swim_beat(plan, surface, gait).recoil / (plan.length, plan.length, 1.0)
    times = np.linspace(0.0, 1.0, len(recoil))
    return np.stack([np.interp(beat % 1.0, times, part) for part in recoil.T], axis=1)


def coast(plan: SpinePlan, surface: SurfacePlan, speed: float, length: float) -> Array:
    """Ways (T + 1,) of a ray that glides over about ``length`` from a ``speed`` per tick on.

    In body lengths. With ℓ = 2 M / (ρ S C) the speed is U / (1 + U t / ℓ).
    """
    parts = wing_strips(plan, surface, np.zeros(3), 0.0, 1.0)
    reach = 2.0 * parts.mass.sum() / (DENSITY * parts.skin.sum() * GLIDE_DRAG) / plan.length
    ticks = np.arange(1 + int(np.ceil(reach / speed * np.expm1(length / reach))))
    return np.asarray(reach * np.log1p(speed * ticks / reach))


def swim_beat(plan: SpinePlan, surface: SurfacePlan, gait: SpineGait) -> Beat:
    """The steady beat of a gait: its stride and recoil, cm."""
    return _swim_beat(*(msgspec.json.encode(one) for one in (plan, surface, gait)))


@lru_cache(maxsize=64)
def _swim_beat(plan_text: bytes, surface_text: bytes, gait_text: bytes) -> Beat:
    plan = msgspec.json.decode(plan_text, type=SpinePlan)
    surface = msgspec.json.decode(surface_text, type=SurfacePlan)
    gait = msgspec.json.decode(gait_text, type=SpineGait)
    period = gait.ticks_per_beat * TICK_S
    beat = np.linspace(0.0, 1.0, TIMES + 1)
    if plan.wings:
        parts = wing_strips(plan, surface, beat, gait.amplitude, period)
    else:
        spine = pose_spine(
            plan, beat, gait.amplitude, np.zeros((len(beat), UNITS)), unit_mass(surface)
        )
        parts = spine_strip(plan, surface, spine.place, period / TIMES, cyclic=True)
    return steady_beat(parts, period, 0.5 * plan.wavelength * plan.length / period)


def spine_strip(
    plan: SpinePlan, surface: SurfacePlan, place: Array, step: float, cyclic: bool
) -> Strips:
    """Sections of an eel whose spine has the joints ``place`` (T, 241, 2), body lengths.

    ``step`` is the time between two poses, s. A cyclic motion ends as it begins.
    """
    length = plan.length
    joints = place[:, None, ::UNITS_OF_SECTION] * length
    joints = np.concatenate([joints, np.zeros_like(joints[..., :1])], axis=-1)
    middle = 0.5 * (joints[..., 1:, :] + joints[..., :-1, :])
    tangent = joints[..., :-1, :] - joints[..., 1:, :]
    size = np.linalg.norm(tangent, axis=-1, keepdims=True)
    tangent = tangent / size
    at = MIDDLES.reshape(-1, UNITS_OF_SECTION).mean(axis=1)
    ds = length / len(at)
    tall = fin_height(surface, at)[None] * length
    body = (
        0.5
        * np.pi
        * along(surface.width, at)
        * (along(surface.back, at) - along(surface.belly, at))
    )
    added = 0.25 * np.pi * DENSITY * tall**2
    return Strips(
        place=middle,
        speed=rate_of(middle, step, cyclic),
        tangent=tangent,
        normal=np.stack([-tangent[..., 1], tangent[..., 0], tangent[..., 2]], axis=-1),
        mass=DENSITY * ds * body[None] * length**2,
        added=added * ds,
        shed=trailing(added),
        across=tall * ds,
        skin=2.0 * tall * ds,
    )


def unit_mass(surface: SurfacePlan) -> Array:
    """Relative mass (n,) of each unit of the spine: its cross-section."""
    back, belly = along(surface.back, MIDDLES), along(surface.belly, MIDDLES)
    return np.asarray(along(surface.width, MIDDLES) * (back - belly))


def fin_height(surface: SurfacePlan, at: Array) -> Array:
    """Height of body and median fins at ``at``, body lengths."""
    back, belly = along(surface.back, at), along(surface.belly, at)
    return np.asarray(
        np.maximum(back, _fin_edge(surface.dorsal, at, back))
        - np.minimum(belly, _fin_edge(surface.ventral, at, belly))
    )


def _fin_edge(fin: FinPlan | None, at: Array, ridge: Array) -> Array:
    if fin is None:
        return ridge
    x, height = np.array(sorted(fin.edge)).T
    return np.where((at >= x[0]) & (at <= x[-1]), np.interp(at, x, height), ridge)


def wing_strips(
    plan: SpinePlan, surface: SurfacePlan, beat: Array, amplitude: float, period: float
) -> Strips:
    """Strips of a ray at the times ``beat`` of a beat; ``amplitude`` (T,) or a number.

    In the plane ahead and up; the third component is to the right. Both wings are counted in one.
    """
    wings, wing = plan.wings, surface.wing
    assert wings and wing
    length, span = plan.length, wing.span
    right = span * (np.arange(STRIPS) + 0.5) / STRIPS
    outline = np.array(wing.outline)
    ahead, rear = outline[: wing.tip + 1], outline[wing.tip :][::-1]
    front = np.interp(right, ahead[:, 1], ahead[:, 0])
    chord = np.interp(right, rear[:, 1], rear[:, 0]) - front
    share = (np.arange(SECTIONS) + 0.5) / SECTIONS
    x = front[:, None] + chord[:, None] * share
    points = np.stack([x, np.zeros_like(x), np.repeat(right[:, None], SECTIONS, axis=1)], axis=-1)
    moved = flap_wings(wings, points.reshape(-1, 3), span, beat, amplitude)
    place = moved.reshape(len(beat), STRIPS, SECTIONS, 3) * length
    place[..., 0] = (plan.centre * length) - place[..., 0]
    tangent = -np.gradient(place, axis=2)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    normal = np.cross(np.gradient(place, axis=1), tangent)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    dx, dy = chord[:, None] * length / SECTIONS, span * length / STRIPS
    area = 2.0 * dx * dy * np.ones_like(x)  # of both wings
    along_chord = chord[:, None] * length * share
    per_length = np.pi * DENSITY * along_chord * dy  # of both wings
    tall = along(surface.back, x) - along(surface.belly, x)
    tall = tall * along(np.asarray(wing.thickness), right / span)[:, None]
    return Strips(
        place=place,
        speed=rate_of(place, period / (len(beat) - 1), cyclic=True),
        tangent=tangent,
        normal=normal,
        mass=DENSITY * area * tall * length,
        added=per_length * dx,
        shed=np.where(share == share[-1], np.pi * DENSITY * chord[:, None] * length * dy, 0.0),
        across=area,
        skin=2.0 * area,
    )


def rate_of(place: Array, step: float, cyclic: bool) -> Array:
    """Velocities of places at even times (axis 0), by central differences."""
    if not cyclic:
        return np.asarray(np.gradient(place, step, axis=0))
    one = place[:-1]
    rate = (np.roll(one, -1, axis=0) - np.roll(one, 1, axis=0)) / (2.0 * step)
    return np.concatenate([rate, rate[:1]])
