"""Water on a body whose deformation is prescribed, and the swimming that follows from it.

The body is a set of strips from front to rear, each a row of sections: an eel is one strip, a wing
several. By large-amplitude elongated-body theory (Lighthill 1971) a section of added mass m that
moves at u along its tangent t, towards the head, and at w along its normal n gives the water the
momentum m w n. The water passes m u w n - ½ m w² t on towards the tail. Where m shrinks, at a tail,
at fins that end in sharp edges and at the rear edges of wings, that part is shed. Cross-flow drag
and skin drag add up. The fish is free: its rigid motion follows from the momentum of body and
water.

Units are cm, g and s. The motion is planar: ahead, aside, and turning from the first to the second.
Vectors have a third component, across this plane, that mirror symmetry cancels.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array

DENSITY = 1.0  # g/cm³; the fish has that of the water, so speeds do not depend on it
CROSS_DRAG = 1.0  # a plate across the flow (Taylor 1952)
SKIN_DRAG = 0.01  # of the wetted area: twice a plate at Re 5e5, as swimming thins the boundary
# layer (up to 1.9 times: Anderson et al. 2001)
MOST_ITERATIONS = 30
CLOSED = 1e-7  # change of momentum in a beat, as a share of the momentum


class Strips(NamedTuple):
    """A deforming body at T times: K strips of J sections, from front to rear."""

    place: Array  # (T, K, J, 3) cm, in axes of the body
    speed: Array  # (T, K, J, 3) cm/s, of the deformation
    tangent: Array  # (T, K, J, 3) towards the head
    normal: Array  # (T, K, J, 3)
    mass: Array  # (K, J) g, of the body
    added: Array  # (K, J) g, added mass of the section
    shed: Array  # (K, J) g/cm, added mass per length that ends behind the section
    across: Array  # (K, J) cm², area that meets cross-flow
    skin: Array  # (K, J) cm², wetted area


class Track(NamedTuple):
    """Rigid motion at N + 1 times, in axes of the body: (ahead, aside, turning)."""

    velocity: Array  # (N + 1, 3) cm/s, cm/s, rad/s
    momentum: Array  # (N + 1, 3) of body and water, about the origin of the body


class Beat(NamedTuple):
    """Steady swimming at N + 1 times of a beat."""

    stride: float  # cm
    recoil: Array  # (N + 1, 3) cm ahead, cm aside and rad, from even motion along the path
    track: Track


def force_and_shed(
    parts: Strips, tangent: Array, normal: Array, velocity: Array
) -> tuple[Array, Array]:
    """Drag on sections, and momentum shed behind them per second, both (K, J, 3), in dyn.

    ``velocity`` (K, J, 3) is relative to the water. The force on the body is the drag less what is
    shed, less the rate of the water's momentum.
    """
    u = np.einsum("kjc,kjc->kj", velocity, tangent)[..., None]
    w = np.einsum("kjc,kjc->kj", velocity, normal)[..., None]
    across, skin = parts.across[..., None], parts.skin[..., None]
    drag = CROSS_DRAG * across * np.abs(w) * w * normal + SKIN_DRAG * skin * np.abs(u) * u * tangent
    shed = parts.shed[..., None] * (u * w * normal - 0.5 * w * w * tangent)
    return -0.5 * DENSITY * drag, shed


def trailing(added: Array) -> Array:
    """Added mass per length (K, J) that is shed behind each section: its decrease."""
    behind = np.concatenate([added[:, 1:], np.zeros_like(added[:, :1])], axis=1)
    return np.maximum(added - behind, 0.0)


def swim(parts: Strips, step: float, momentum: Array, trim: Array | None = None) -> Track:
    """Free swimming from ``momentum`` (3,) on, by Runge-Kutta steps of two times of ``parts``.

    ``step`` is the time between two of its 2 N + 1 times, s; ``trim`` (3,) a constant force and
    moment.
    """
    basis, inertia, own = _generalized(parts)
    trim = np.zeros(3) if trim is None else trim

    def rate(t: int, now: Array) -> tuple[Array, Array]:
        moving = np.linalg.solve(inertia[t], now - own[t])
        velocity = np.einsum("akjc,a->kjc", basis[t], moving) + parts.speed[t]
        drag, shed = force_and_shed(parts, parts.tangent[t], parts.normal[t], velocity)
        force = np.einsum("akjc,kjc->a", basis[t], drag - shed) + trim
        turning = moving[2]
        # Axes of the body turn and move on.
        force[0] += turning * now[1]
        force[1] -= turning * now[0]
        force[2] -= moving[0] * now[1] - moving[1] * now[0]
        return force, moving

    count = (len(parts.place) - 1) // 2
    now = np.asarray(momentum, np.float64)
    velocities, momenta = np.empty((count + 1, 3)), np.empty((count + 1, 3))
    h = 2.0 * step
    for k in range(count):
        a, velocities[k] = rate(2 * k, now)
        momenta[k] = now
        b, _ = rate(2 * k + 1, now + 0.5 * h * a)
        c, _ = rate(2 * k + 1, now + 0.5 * h * b)
        d, _ = rate(2 * k + 2, now + h * c)
        now = now + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    velocities[count], momenta[count] = rate(2 * count, now)[1], now
    return Track(velocities, momenta)


def start_momentum(parts: Strips, velocity: Array) -> Array:
    """Momentum (3,) of body and water at the first time, at a rigid ``velocity`` (3,)."""
    _, inertia, own = _generalized(parts._replace(**{k: getattr(parts, k)[:1] for k in _MOVING}))
    return np.asarray(inertia[0] @ velocity + own[0])


_MOVING = ("place", "speed", "tangent", "normal")


def _generalized(parts: Strips) -> tuple[Array, Array, Array]:
    """Velocities (T, 3, K, J, 3) of unit motions, inertia (T, 3, 3) and own momentum (T, 3)."""
    place = parts.place
    basis = np.zeros((len(place), 3, *place.shape[1:]))
    basis[:, 0, ..., 0] = basis[:, 1, ..., 1] = 1.0
    basis[:, 2, ..., 0], basis[:, 2, ..., 1] = -place[..., 1], place[..., 0]
    lead = np.einsum("takjc,tkjc->takj", basis, parts.normal)
    inertia = np.einsum("kj,takjc,tbkjc->tab", parts.mass, basis, basis)
    inertia += np.einsum("kj,takj,tbkj->tab", parts.added, lead, lead)
    w = np.einsum("tkjc,tkjc->tkj", parts.speed, parts.normal)
    own = np.einsum("kj,takjc,tkjc->ta", parts.mass, basis, parts.speed)
    own += np.einsum("kj,takj,tkj->ta", parts.added, lead, w)
    return basis, inertia, own


def steady_beat(parts: Strips, period: float, speed: float) -> Beat:
    """Find the motion that repeats with the beat: the mean force over it is zero.

    ``parts`` are a beat and its end; ``speed`` is a first guess, cm/s. As real fishes trim
    themselves, a constant sideward force and moment cancel drift and turning; for a beat whose
    second half mirrors the first they are zero. RuntimeError if the search fails.
    """
    step = period / (len(parts.place) - 1)
    momentum = start_momentum(parts, np.array([speed, 0.0, 0.0]))
    for _ in range(3):
        momentum = swim(parts, step, momentum).momentum[-1]
    size = np.linalg.norm(parts.place[0], axis=-1).max()
    scale = abs(momentum[0]) * np.array([1.0, 1.0, size])
    units = np.concatenate([scale, scale[1:] / period])
    drift = np.array([speed, speed / size])

    def residual(x: Array) -> tuple[Array, Track]:
        trim = np.array([0.0, *x[3:]]) * [0.0, *units[3:]]
        track = swim(parts, step, x[:3] * scale, trim)
        change = (track.momentum[-1] - track.momentum[0]) / scale
        mean = np.mean(track.velocity[:-1, 1:], axis=0) / drift
        return np.concatenate([change, mean]), track

    x = np.concatenate([momentum / scale, [0.0, 0.0]])
    for _ in range(MOST_ITERATIONS):
        left, track = residual(x)
        if np.abs(left).max() < CLOSED:
            return _beat(track, 2.0 * step)
        slopes = [(residual(x + 1e-4 * e)[0] - left) / 1e-4 for e in np.eye(5)]
        x = x - np.linalg.solve(np.stack(slopes, axis=1), left)
    raise RuntimeError("the gait has no steady speed")


def follow(velocity: Array, step: float) -> Array:
    """Places (N + 1, 3), cm, cm and rad, by the trapezoidal rule, from velocities in body axes."""
    turned = _integral(velocity[:, 2], step)
    c, s = np.cos(turned), np.sin(turned)
    ahead = _integral(c * velocity[:, 0] - s * velocity[:, 1], step)
    aside = _integral(s * velocity[:, 0] + c * velocity[:, 1], step)
    return np.stack([ahead, aside, turned], axis=1)


def _integral(values: Array, step: float) -> Array:
    return np.concatenate([[0.0], np.cumsum(0.5 * step * (values[1:] + values[:-1]))])


def _beat(track: Track, step: float) -> Beat:
    """The beat in axes of its path."""
    way = follow(track.velocity, step)
    stride = float(np.hypot(way[-1, 0], way[-1, 1]))
    along = np.arctan2(way[-1, 1], way[-1, 0])
    c, s = np.cos(along), np.sin(along)
    recoil = way @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    recoil[:, 0] -= stride * np.linspace(0.0, 1.0, len(way))
    recoil[:, :2] -= recoil[:-1, :2].mean(axis=0)
    recoil[:, 2] -= along
    return Beat(stride, recoil, track)
