"""The secondary controller: from a wanted direction and speed to a segment (SMC §6.1)."""

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

SHARP_RAD = np.radians(70.0)  # beyond this angle a fish throws itself round
GRADUAL_RAD = np.radians(24.0)  # beyond this it bends its beat
RELEASE_RAD = np.radians(9.0)  # a gradual turn ends here, well inside, so that it doesn't flutter
STEER_RAD = np.radians(45.0)  # careful alignment happens inside this angle (SMC §6.2)
YAW_RATE = np.radians(24.0)  # rad/s: the most that careful alignment adds, for a recorded fish
PITCH_RATE = np.radians(32.0)
STEER_GAIN = 1.6  # 1/s: share of the angle that is closed in a second
STEER_EASE = np.radians(90.0)  # rad/s²: how fast the alignment's own rate may change
MAX_PITCH_RAD = np.radians(38.0)  # fishes do not swim steeper than this of their own will
TEMPO_EASE = 0.8  # 1/s: how fast the rate may change
THRUST_EASE = 1.2  # 1/s: from full way to standing still in less than a second
RETREAT = -0.6  # the fastest retreat, as a share of the slow swim's way
MONOTONY_S = (4.0, 9.0)  # the fish gets bored of a segment after so long
MONOTONY_PURPOSE = 50  # key of the random numbers
GRADE_MARGIN = 1.12  # a fish keeps its grade until another fits better by this factor


@kernel
def command(fishes: Fishes, library: Library, clock: Clock) -> None:
    """Choose `wanted_segment`; ease `tempo`, `thrust` and `steering` toward what the goal asks.

    The angle to the goal in the horizontal plane chooses between swims and turns, its height the
    pitch, the goal's speed the grade. Playback takes the choice up at the next row from which
    the glide is gentle.
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

        # Slower than the slowest swim: the same strokes with less way, down to backing off.
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

        # A large fish swings round more slowly, as it beats more slowly.
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
    """Time the present segment; past the threshold recommend another swim at random (SMC §6.1).

    The intention generator may refuse. The timer starts anew either way.
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
    """The swim whose speed is nearest by ratio to the wanted share of the fastest."""
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
