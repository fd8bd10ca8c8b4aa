"""Chase and follow targets, and burst: shared by several behaviors (Tu §7.8.2)."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.geometry.rotation import rotate, x_axis
from subsea.geometry.vector import Vector, dot, minus, norm, plus, store, times, vector
from subsea.kernels import kernel
from subsea.state import Clock, Fishes, Minds
from subsea.state.places import place_near

NEAR_BL = 1.5  # distance within which a fish slows down, for better control
LEAST_SPEED = 0.25  # share of the fastest speed at which it arrives
LEAST_BL_S = 0.4  # least speed, body lengths per second, for predicting an interception
CIRCLE_BL = 2.2  # radius of a gradual turn at full speed
TURNING = 0.12  # share of the fastest speed for turning toward a target that is too near
BESIDE = 0.3  # share of the fastest speed beside a fish that it follows
FORESIGHT_S = 2.0  # how far ahead the motion of a target is predicted
LASTING_S = 3.0  # length of a full burst; then a fish has only its sustained speed ...
FRESH = 0.4  # ... and the share of this time in which it is at its fastest
RECOVERS = 0.08  # s of burst recovered in a second without one


@kernel
def chase(fishes: Fishes, minds: Minds, i: int, target: Vector, velocity: Vector) -> float:
    """Head for a target (cm) that moves at `velocity` (cm/s); returns its distance from the mouth.

    The fish aims at the point of interception. It slows down as it approaches, and further while a
    target beside it lies inside its turning circle; otherwise it would circle it for ever.
    """
    mouth = mouth_of(fishes, i)
    toward = minus(target, mouth)
    distance = norm(toward)
    speed = max(norm(vector(fishes.velocity[i])), LEAST_BL_S * fishes.length[i])
    meeting = min(distance / max(speed, 1.0), FORESIGHT_S)
    ahead = plus(toward, times(meeting, minus(velocity, vector(fishes.drift[i]))))
    set_urge(minds, i, ahead)
    share = max(distance / (NEAR_BL * fishes.length[i]), LEAST_SPEED)
    heading = x_axis(fishes.orientation[i])
    cosine = dot(heading, ahead) / max(norm(ahead), 1e-6)
    sine = np.sqrt(max(1.0 - cosine * cosine, 0.0)) if cosine > 0.0 else 1.0
    # A target at that angle is reached if it is the chord 2 R sin away.
    wide = 2.0 * CIRCLE_BL * fishes.length[i] * sine
    turning = max(distance / max(wide, 1e-6), TURNING)
    fishes.goal_speed[i] = min(share, turning, 1.0)
    return distance


@kernel
def follow(fishes: Fishes, minds: Minds, i: int, j: int) -> None:
    """Chase fish j, and slow down beside it."""
    place = place_near(fishes, j, vector(fishes.position[i]))
    distance = chase(fishes, minds, i, place, vector(fishes.velocity[j]))
    if distance < fishes.length[i] + fishes.length[j]:
        fishes.goal_speed[i] = min(fishes.goal_speed[i], BESIDE)


@kernel
def set_urge(minds: Minds, i: int, urge: Vector) -> None:
    """Set the direction in which fish i wants to go."""
    store(minds.urge[i], urge)


@kernel
def mouth_of(fishes: Fishes, i: int) -> Vector:
    """The tip of the snout of fish i, cm, world."""
    along = rotate(fishes.orientation[i], (float(fishes.snout[i]), 0.0, 0.0))
    return plus(vector(fishes.position[i]), along)


@kernel
def burst(fishes: Fishes, minds: Minds, i: int) -> None:
    """Let fish i swim as fast as it can: at its burst speed while fresh, less as it tires."""
    fresh = min(max(1.0 - minds.spent[i] / LASTING_S, 0.0) / (1.0 - FRESH), 1.0)
    fishes.goal_speed[i] = 1.0 + (max(fishes.burst[i], 1.0) - 1.0) * fresh


@kernel
def tire(who: Ints, fishes: Fishes, minds: Minds, clock: Clock) -> None:
    """Count the time of bursts of the fishes `who`, by their effort, and their rest."""
    for i in who:
        effort = (fishes.goal_speed[i] - 1.0) / max(fishes.burst[i] - 1.0, 1e-3)
        change = min(effort, 1.0) if effort > 0.0 else -RECOVERS
        minds.spent[i] = max(minds.spent[i] + np.float32(change * clock.dt), np.float32(0.0))
        minds.startled[i] += np.float32(clock.dt)
