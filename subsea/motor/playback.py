"""Play recorded motion and glides (SMC §5.1, §5.2), one pass per tick."""

from subsea.core.kernels import kernel
from subsea.geometry.rotation import (
    Quaternion,
    about,
    fraction,
    mixed,
    multiply,
    normalised,
    quaternion,
    rotate,
)
from subsea.geometry.vector import Vector, plus, store, times, vector
from subsea.motor.balance import balanced
from subsea.repertoire.library import Library
from subsea.state import Fishes

TEMPO = (0.75, 1.3)  # range of a segment's rate, to meet a speed


@kernel
def play(fishes: Fishes, library: Library, dt: float) -> None:
    """Advance every fish by one tick of recorded motion, steering, balance and drift.

    Simulated fishes have already moved (`motor/dynamics.py`).
    """
    per_second = 1.0 / dt
    for i in range(len(fishes.species)):
        if fishes.live[i] or not fishes.alive[i]:
            continue
        store(fishes.previous_position[i], vector(fishes.position[i]))
        store(fishes.previous_orientation[i], quaternion(fishes.orientation[i]))
        fishes.previous_row_a[i] = fishes.row_a[i]
        fishes.previous_row_b[i] = fishes.row_b[i]
        fishes.previous_weight[i] = fishes.weight[i]
        fishes.previous_span[i] = fishes.span[i]

        o, q = advance(fishes, library, i)
        q = _steer(q, fishes.steering[i, 0] * dt, fishes.steering[i, 1] * dt)
        q = normalised(balanced(fishes, i, q, dt))
        for axis in range(3):
            place = o[axis] + fishes.drift[i, axis] * dt
            fishes.velocity[i, axis] = (place - fishes.position[i, axis]) * per_second
            fishes.position[i, axis] = place
        store(fishes.orientation[i], q)


@kernel
def advance(fishes: Fishes, library: Library, i: int) -> tuple[Vector, Quaternion]:
    """Play fish i for one tick: its new origin and orientation.

    R ← R·M, o ← o + R·αt (SMC eqs. 10, 11). A fraction f of a row moves by M^f and f t, so that
    the fractions of a row add up to it. Advances row a, row b, weight, span and segment in place.
    """
    o = vector(fishes.position[i])
    q = quaternion(fishes.orientation[i])
    weight = float(fishes.weight[i])
    left = 1.0  # of the tick
    while left > 0.0:
        span = float(fishes.span[i])
        a, b = fishes.row_a[i], fishes.row_b[i]
        gliding = span > 1.0
        tempo, thrust = float(fishes.tempo[i]), float(fishes.thrust[i])
        if gliding:
            tempo = (1.0 - weight) * fishes.glide_tempo[i] + weight * tempo
            thrust = (1.0 - weight) * fishes.glide_thrust[i] + weight * thrust
        rate = fishes.rate[i] * tempo  # frames in a tick
        until_b = (1.0 - weight) * span
        frames = min(left * rate, until_b)
        rotation = quaternion(library.rotation[b])
        shift = vector(library.translation[b])
        if gliding:
            # A glide blends the last increment into the next one.
            middle = weight + 0.5 * frames / span
            rotation = mixed(quaternion(library.rotation[a]), rotation, middle)
            before = vector(library.translation[a])
            shift = plus(times(1.0 - middle, before), times(middle, shift))
        elif weight > 0.0:
            # Translations are recorded in the axes that the row began with.
            shift = rotate(fraction(rotation, -weight), shift)
        step = rotate(q, shift)
        o = plus(o, times(frames * fishes.scale[i] * thrust, step))
        q = multiply(q, rotation if frames == 1.0 else fraction(rotation, frames))
        left -= frames / rate
        weight += frames / span
        if until_b <= frames:
            weight = 0.0
            _next_row(fishes, library, i)
    fishes.weight[i] = weight
    return o, q


@kernel
def _next_row(fishes: Fishes, library: Library, i: int) -> None:
    """Make row b row a, and choose the next row b."""
    kind = fishes.species[i]
    now = fishes.segment[i]
    a = fishes.row_b[i]
    first = library.first[kind, now]
    at_end = a == first + library.length[kind, now] - 1
    wanted = fishes.wanted_segment[i]
    may_leave = library.leave[a, wanted] or (at_end and not library.cyclic[kind, now])
    fishes.row_a[i] = a
    if may_leave and (wanted != now or not library.cyclic[kind, now]):
        fishes.row_b[i] = library.entry[a, wanted]
        fishes.span[i] = library.glide[a, wanted]
        fishes.segment[i] = wanted
        _keep_speed(fishes, i, library.speed[kind, now] / library.speed[kind, wanted])
    else:
        fishes.row_b[i] = first if at_end else a + 1
        fishes.span[i] = 1.0


@kernel
def _keep_speed(fishes: Fishes, i: int, ratio: float) -> None:
    """Keep the speed in a new segment; `ratio` is the old recorded speed over the new one.

    The tempo takes up what it can and the thrust the rest: a fish that slows down coasts. The
    controller then eases both toward the goal.
    """
    fishes.glide_tempo[i] = fishes.tempo[i]
    fishes.glide_thrust[i] = fishes.thrust[i]
    exact = fishes.tempo[i] * ratio
    fishes.tempo[i] = min(max(exact, TEMPO[0]), TEMPO[1])
    fishes.thrust[i] *= exact / fishes.tempo[i]


@kernel
def _steer(q: Quaternion, yaw: float, pitch: float) -> Quaternion:
    """Turn left by `yaw` about the world's vertical and raise the nose by `pitch`, rad."""
    q = multiply(about(0.0, 0.0, 1.0, yaw), q)
    return multiply(q, about(0.0, 0.0, 1.0, pitch))
