"""The secondary controller: choose a segment for a goal direction and speed (SMC §6.1)."""

import numpy as np

from subsea.core.arrays import Array
from subsea.core.kernels import kernel
from subsea.geometry.keyed_random import uniform
from subsea.geometry.rotation import x_axis
from subsea.motor.playback import TEMPO
from subsea.repertoire.library import Library
from subsea.state import Clock, Fishes

# Codes of repertoire.schema.SEGMENTS, as plain numbers for the compiled kernel.
SLOW, MEDIUM, FAST, LEFT_GRADUAL, LEFT_SHARP, RIGHT_GRADUAL, RIGHT_SHARP = range(7)

SHARP_RAD = np.radians(70.0)  # beyond this angle a fish makes a sharp turn
GRADUAL_RAD = np.radians(24.0)  # beyond this a gradual turn
RELEASE_RAD = np.radians(9.0)  # a gradual turn ends here: hysteresis
STEER_RAD = np.radians(45.0)  # careful alignment happens inside this angle (SMC §6.2)
YAW_RATE = np.radians(24.0)  # rad/s: the most that careful alignment adds to a recorded fish
PITCH_RATE = np.radians(32.0)
STEER_GAIN = 1.6  # 1/s: share of the angle closed per second
STEER_EASE = np.radians(90.0)  # rad/s²: how fast the rate of alignment may change
MAX_PITCH_RAD = np.radians(38.0)  # the steepest that fishes swim
TEMPO_EASE = 0.8  # 1/s: how fast the rate may change
THRUST_EASE = 1.2  # 1/s: full thrust to hovering in less than a second
RETREAT = -0.6  # least thrust: the fastest retreat, over the slow swim
MONOTONY_S = (4.0, 9.0)  # after which a fish tires of a segment, by its identity
MONOTONY_PURPOSE = np.int64(50)  # key of the random numbers
GRADE_MARGIN = 1.12  # factor by which another grade must fit better


@kernel
def command(fishes: Fishes, library: Library, clock: Clock) -> None:
    """Choose `wanted_segment`; ease `tempo`, `thrust` and `steering` toward the goal.

    The horizontal angle to the goal selects a swim or a turn, its elevation the pitch, and the
    goal's speed the grade. Playback changes over at the next row with a gentle glide.
    """
    dt = clock.dt
    for i in range(len(fishes.species)):
        kind = fishes.species[i]
        x = x_axis(fishes.orientation[i])
        g = fishes.goal_direction[i]
        azimuth = np.arctan2(x[0] * g[1] - x[1] * g[0], x[0] * g[0] + x[1] * g[1])
        climb = np.arctan2(np.float64(g[2]), np.sqrt(np.float64(g[0] * g[0] + g[1] * g[1])))
        climb = min(max(climb, -MAX_PITCH_RAD), MAX_PITCH_RAD)
        pitch = np.arcsin(min(max(x[2], -1.0), 1.0))

        now = fishes.segment[i]
        angle = abs(azimuth)
        turning = now in (LEFT_GRADUAL, RIGHT_GRADUAL)
        same_side = (now == LEFT_GRADUAL) == (azimuth > 0.0)
        if angle > SHARP_RAD:
            wanted = LEFT_SHARP if azimuth > 0.0 else RIGHT_SHARP
        elif angle > GRADUAL_RAD or (turning and same_side and angle > RELEASE_RAD):
            wanted = LEFT_GRADUAL if azimuth > 0.0 else RIGHT_GRADUAL
        else:
            wanted = _grade(library.speed[kind], now, fishes.goal_speed[i])
        fishes.wanted_segment[i] = wanted

        # Below the slowest swim: the same strokes with less thrust, down to a retreat.
        slowest = TEMPO[0] * library.speed[kind, SLOW] / library.speed[kind, FAST]
        thrust = min(max(fishes.goal_speed[i] / slowest, RETREAT), 1.0)
        ease = THRUST_EASE * dt
        fishes.thrust[i] += np.float32(min(max(thrust - fishes.thrust[i], -ease), ease))

        tempo = 1.0
        if wanted <= FAST:
            goal = fishes.goal_speed[i] * library.speed[kind, FAST]
            tempo = min(max(goal / library.speed[kind, wanted], TEMPO[0]), TEMPO[1])
        ease = TEMPO_EASE * dt
        fishes.tempo[i] += np.float32(min(max(tempo - fishes.tempo[i], -ease), ease))

        # Large fishes beat more slowly and turn more slowly.
        rate = np.float64(fishes.rate[i])
        yaw = 0.0
        if angle < STEER_RAD:
            yaw = min(max(STEER_GAIN * azimuth, -YAW_RATE), YAW_RATE) * rate
        lift = min(max(STEER_GAIN * (climb - pitch), -PITCH_RATE), PITCH_RATE) * rate
        ease = STEER_EASE * dt
        fishes.steering[i, 0] += np.float32(min(max(yaw - fishes.steering[i, 0], -ease), ease))
        fishes.steering[i, 1] += np.float32(min(max(lift - fishes.steering[i, 1], -ease), ease))

        _watch_monotony(fishes, i, clock)


@kernel
def _watch_monotony(fishes: Fishes, i: int, clock: Clock) -> None:
    """Time the segment; past the threshold recommend another swim at random (SMC §6.1).

    The intention generator may ignore it. The timer restarts in any case.
    """
    fishes.recommended[i] = -1
    if fishes.segment[i] != fishes.wanted_segment[i]:
        fishes.monotony[i] = 0.0
        return
    fishes.monotony[i] += np.float32(clock.dt)
    low, high = MONOTONY_S
    if fishes.monotony[i] > low + (high - low) * fishes.identity[i]:
        fishes.monotony[i] = 0.0
        other = int(2.0 * uniform(clock.seed, i, clock.tick, MONOTONY_PURPOSE))
        if other >= fishes.segment[i]:
            other += 1
        fishes.recommended[i] = other


@kernel
def _grade(speed: Array, now: int, share: float) -> int:
    """The swim whose speed is nearest, by ratio, to the share of the fastest."""
    goal = max(share, 0.01) * speed[FAST]
    best = SLOW
    least = np.inf
    for grade in (SLOW, MEDIUM, FAST):
        gap = abs(np.log(goal / speed[grade]))
        if grade == now:
            gap -= np.log(GRADE_MARGIN)
        if gap < least:
            best, least = grade, gap
    return best
