"""The secondary controller: choose a segment for a goal direction and speed (SMC §6.1)."""

import math

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.biomechanics.solver import TICK_S
from subsea.geometry.angles import arc_sine, arc_tangent
from subsea.geometry.noise import uniform
from subsea.geometry.rotation import x_axis
from subsea.kernels import kernel
from subsea.motor.playback import (
    BASE,
    BURST,
    COAST,
    FAST,
    FIRST_CSTART,
    HURRIED,
    LAST_CSTART,
    LEAST_TEMPO,
    LEFT_GLIDE,
    LEFT_REST,
    LEFT_SHARP,
    MEDIUM,
    RIGHT_SHARP,
    ROW,
    SLOW,
    START,
    STOP,
    TEMPO,
    TURNS,
    between,
    blends,
    is_cstart,
)
from subsea.repertoire.blending import LEVELS, TIGHTEST
from subsea.repertoire.library import Library
from subsea.state import Clock, Fishes

SHARP_SHARE = 0.7  # share of the angle of a sharp turn beyond which a fish turns sharply ...
SHARP_RAD = np.radians(30.0)  # ... unless the angle is less than this
BEGIN_RAD = np.radians(10.0)  # a turn that cannot be blended begins beyond this angle
RELEASE_RAD = np.radians(3.0)  # ... and ends within this angle
STRAIGHT_RAD = np.radians(15.0)  # a bursting fish does not turn within this angle
LEAVE_RAD = np.radians(4.0)  # within it a slow or fast swim is not left for one that bends
YAW_RATE = np.radians(30.0)  # rad/s: the fastest turn on the spot by pectoral fins
PITCH_RATE = np.radians(32.0)
STEER_GAIN = 1.6  # 1/s: share of the angle closed per second
BEND_GAIN = 2.5  # 1/s: likewise by bends, of the angle from the head, which leads the way
STILL_GAIN = 1.5  # 1/s: likewise of a body without a beat, whose bend changes more slowly
STEER_EASE = np.radians(90.0)  # rad/s², at the recorded pace: how fast that rate may change
MAX_PITCH_RAD = np.radians(20.0)  # the steepest that fishes swim ...
BURST_PITCH_RAD = np.radians(38.0)  # ... in a burst ...
ROW_PITCH_RAD = np.radians(65.0)  # ... and by their fins alone, which hold the body at any pitch
TILTED = np.sin(np.radians(25.0))  # sine of the pitch of a fish that rows until it is level
STEEP = np.cos(np.radians(60.0))  # level share of a goal's direction below which turns are smaller
TEMPO_EASE = 1.2  # 1/s: how fast the tempo may change
BURST_EASE = 15.0  # 1/s: likewise in a hurry, so that a fish bursts within 0.2 s
SLOWING = 2.0  # 1/s: likewise after a burst
THRUST_EASE = 1.2  # 1/s: full thrust to hovering in less than a second
RETREAT = -0.6  # least thrust: the fastest retreat, over the slow swim
CSTART_TEMPO = 3.0  # the first stage takes less than 0.1 s
TURN_TEMPO = (1.0, 2.0)  # range of the tempo in sharp turns
ROW_TEMPO = 1.5  # fastest beat of the pectoral fins; the tail beats above it ...
TAIL_SHARE = 0.7  # ... or above this share of the fast swim
KEEP_ROWING = 1.15  # factor on that speed for a fish that rows: hysteresis
RHYTHM = (0.15, 0.3)  # shares by which burst and coast leave the wanted speed, by identity
STEADY = 0.8  # share of the fast swim from which a fish beats without pause ...
SLOW_DOWN = 1.2  # ... while it is at most this much faster than it wants
REACHED = 1.1  # speed for which a burst beats, over that at which it ends
HOVER = 0.1  # share of the slow swim below which a fish stands in the water
BRAKING = 1.8  # speed over the wanted one from which fins brake a coast
STAND_TIME_S = 1.0  # time constant of a fish that stops, at the recorded size
CYCLE_S = 6.0  # cycle of beats and stops below the slowest beat, without a recorded coast
MOVING = 0.3  # share of the slow swim above which a fish need not start from rest
MONOTONY_S = (4.0, 9.0)  # after which a fish tires of a segment, by its identity
MONOTONY_PURPOSE = np.int64(50)  # key of the random numbers
GRADE_MARGIN = 1.2  # factor by which another grade must fit better


@kernel
def command(who: Ints, fishes: Fishes, library: Library, clock: Clock) -> None:
    """Choose `wanted_segment` of the fishes `who`, and ease the rest toward their goals.

    The rest is tempo, thrust, bend and steering. The horizontal angle to the goal selects a swim or
    a turn, its elevation the pitch, and the goal's speed grade and tempo. Playback changes over at
    the next row with a gentle glide.
    """
    dt = clock.dt
    for i in who:
        kind = fishes.species[i]
        x = x_axis(fishes.orientation[i])
        g = fishes.goal_direction[i]
        azimuth = arc_tangent(x[0] * g[1] - x[1] * g[0], x[0] * g[0] + x[1] * g[1])
        # Nearly above or below, a goal is at any azimuth: swim on, and climb or dive.
        level = math.sqrt(np.float64(g[0] * g[0] + g[1] * g[1]))
        azimuth *= min(level / STEEP, 1.0)
        azimuth += _sway(fishes, library, i)
        share = min(np.float64(fishes.goal_speed[i]), np.float64(fishes.burst[i]))
        if fishes.ram[i] > 0.0:
            share = max(share, np.float64(fishes.ram[i]))
        speed = share * library.speed[kind, FAST]
        if fishes.startle[i] != 0.0:
            _startle(fishes, library, i)
        wanted = fishes.wanted_segment[i]
        if not is_cstart(wanted) or fishes.segment[i] == wanted:
            wanted = _swim(fishes, library, i, speed, clock)
            wanted, speed = _burst_and_coast(fishes, library, i, wanted, speed, dt)
            wanted = _turn(fishes, library, i, azimuth, wanted, dt)
            fishes.wanted_segment[i] = wanted
        _ease_speed(fishes, library, i, speed, dt)

        # Large fishes beat more slowly and turn more slowly.
        rate = np.float64(fishes.rate[i])
        now = fishes.segment[i]
        rows = now == STOP or (now == ROW and not blends(library, kind, ROW))
        yaw = min(max(STEER_GAIN * azimuth, -YAW_RATE), YAW_RATE) * rate if rows else 0.0
        steepest = BURST_PITCH_RAD if share > HURRIED else MAX_PITCH_RAD
        steepest = ROW_PITCH_RAD if BASE[now] == ROW else steepest
        climb = arc_tangent(np.float64(g[2]), level)
        climb = min(max(climb, -steepest), steepest) - arc_sine(x[2])
        lift = min(max(STEER_GAIN * climb, -PITCH_RATE), PITCH_RATE) * rate
        ease = STEER_EASE * rate * rate * dt
        fishes.steering[i, 0] += np.float32(min(max(yaw - fishes.steering[i, 0], -ease), ease))
        fishes.steering[i, 1] += np.float32(min(max(lift - fishes.steering[i, 1], -ease), ease))

        _watch_monotony(fishes, i, clock)


@kernel
def _sway(fishes: Fishes, library: Library, i: int) -> float:
    """Heading of fish i beyond its mean course, rad: the beat of its head."""
    a, b = fishes.row_a[i], fishes.row_b[i]
    weight = float(fishes.weight[i])
    return (1.0 - weight) * library.sway[a] + weight * library.sway[b]


@kernel
def _startle(fishes: Fishes, library: Library, i: int) -> None:
    """Ask for the recorded escape nearest to the angle of the startle, unless one is under way."""
    angle = float(fishes.startle[i])
    fishes.startle[i] = 0.0
    if is_cstart(fishes.segment[i]) or not fishes.alive[i]:
        return
    kind, least = fishes.species[i], np.inf
    for code in range(FIRST_CSTART, LAST_CSTART + 1):
        gap = abs(library.turn[kind, code] - angle)
        if gap < least:
            fishes.wanted_segment[i], least = code, gap
    fishes.tempo[i] = fishes.glide_tempo[i] = CSTART_TEMPO


@kernel
def _swim(fishes: Fishes, library: Library, i: int, speed: float, clock: Clock) -> int:
    """The swim for a speed, cm/s at the recorded size and pace.

    A fish with its nose down or up levels out by its fins before it beats its tail.
    """
    kind, now = fishes.species[i], fishes.segment[i]
    own, has = library.speed[kind], library.has[kind]
    if has[ROW]:
        most = min(KEEP_ROWING * ROW_TEMPO * own[ROW], TAIL_SHARE * own[FAST])
        most /= 1.0 if BASE[now] == ROW else KEEP_ROWING
        if speed < max(most, TEMPO[0] * own[SLOW]) or _is_tilted(fishes, i):
            return ROW
    elif has[COAST] and has[STOP] and fishes.ram[i] == 0.0 and speed < HOVER * own[SLOW]:
        return STOP
    elif not has[COAST] and has[STOP] and fishes.ram[i] == 0.0 and speed < TEMPO[0] * own[SLOW]:
        # The share of the cycle in which it beats sets the speed.
        cycle = clock.tick * clock.dt * fishes.rate[i] / CYCLE_S + fishes.identity[i]
        return SLOW if cycle % 1.0 < speed / (TEMPO[0] * own[SLOW]) else STOP
    if now == STOP and has[START] and fishes.thrust[i] < MOVING:
        return START
    return _grade(own, has[BURST], now, speed)


@kernel
def _is_tilted(fishes: Fishes, i: int) -> bool:
    """True if fish i rows with its nose down or up, and is in no hurry."""
    rows = BASE[fishes.segment[i]] == ROW and fishes.goal_speed[i] <= HURRIED
    return bool(rows and abs(x_axis(fishes.orientation[i])[2]) > TILTED)


@kernel
def _burst_and_coast(
    fishes: Fishes, library: Library, i: int, swim: int, speed: float, dt: float
) -> tuple[int, float]:
    """The swim or a coast, and the speed to beat for, of fish i that wants a mean speed.

    A fish beats until it is faster than that, coasts until it is slower, and so on, each in its
    own rhythm: it keeps still most of the time and needs less work. One in a hurry and one
    that breathes by swimming beat without pause. A fish that rows coasts to the speed of its oars.
    """
    kind, now = fishes.species[i], fishes.segment[i]
    own = library.speed[kind]
    if not library.has[kind, COAST] or fishes.ram[i] > 0.0 or swim in (STOP, START):
        return swim, speed
    if fishes.goal_speed[i] > HURRIED or is_cstart(now):
        return swim, speed
    low, high = speed, SLOW_DOWN * speed
    if swim == ROW:
        low = max(speed, np.float64(own[ROW]))
        high = SLOW_DOWN * low if BASE[now] != ROW else np.inf
    elif speed < STEADY * own[FAST]:
        least, most = RHYTHM
        share = least + (most - least) * np.float64(fishes.identity[i])
        high = max((1.0 + share) * speed, TEMPO[0] * own[SLOW])
        low = max(2.0 * speed - high, (1.0 - 2.0 * most) * speed)
    frames = np.float64(fishes.rate[i]) * fishes.scale[i] * TICK_S
    if through_water(fishes, i) * dt / frames > (low if BASE[now] == COAST else high):
        return COAST, speed
    if swim == ROW or high == SLOW_DOWN * speed:
        return swim, speed
    return _grade(own, library.has[kind, BURST], now, REACHED * high), REACHED * high


@kernel
def through_water(fishes: Fishes, i: int) -> float:
    """Measure the speed of fish i through the water, cm/s, of the tick before."""
    way = 0.0
    for axis in range(3):
        way += (np.float64(fishes.velocity[i, axis]) - fishes.drift[i, axis]) ** 2
    return math.sqrt(way)


@kernel
def _turn(fishes: Fishes, library: Library, i: int, azimuth: float, swim: int, dt: float) -> int:
    """The turn toward `azimuth`, rad, or the swim if it leads there; sets `bend`.

    Bends of the gradual turn blend with the straight swim; a large angle takes a sharp turn, on
    the spot one from rest, and in a glide one from a glide, where they were recorded. All begin
    level: a fish with its nose down turns by its fins.
    """
    kind, now = fishes.species[i], fishes.segment[i]
    has, angle = library.has[kind], abs(azimuth)
    side = 0 if azimuth > 0.0 else 1
    fishes.bend[i] = 0.0
    sharp = LEFT_SHARP if side == 0 else RIGHT_SHARP
    if (now == STOP or BASE[now] in (ROW, COAST)) and not fishes.live[i]:
        pace = fishes.tempo[i] if BASE[now] == COAST else fishes.thrust[i]
        if has[LEFT_REST] and abs(pace) < MOVING:
            sharp = LEFT_REST + side
        elif has[LEFT_GLIDE]:
            sharp = LEFT_GLIDE + side
    wide = angle > max(SHARP_SHARE * abs(library.turn[kind, sharp]), SHARP_RAD)
    if wide and not (swim == ROW and _is_tilted(fishes, i)):
        return sharp
    base = swim if swim in (ROW, COAST) else MEDIUM
    if swim in (STOP, START) or (base != MEDIUM and not blends(library, kind, base)):
        return swim
    gradual = TURNS[base, side]
    if not blends(library, kind, base):
        least = RELEASE_RAD if now == gradual else BEGIN_RAD
        return gradual if angle > least else swim
    if fishes.goal_speed[i] > HURRIED and angle < (RELEASE_RAD if now == gradual else STRAIGHT_RAD):
        return swim
    full = abs(library.turn[kind, gradual]) / (library.length[kind, gradual] * dt)
    gain = BEND_GAIN if base == MEDIUM else STILL_GAIN
    bend = gain * azimuth / (full * fishes.tempo[i])
    bend = min(max(bend, -TIGHTEST / LEVELS), TIGHTEST / LEVELS)
    if abs(bend) * LEVELS < 0.5 or (angle < LEAVE_RAD and BASE[now] != base):
        return swim
    fishes.bend[i] = bend
    return gradual


@kernel
def _ease_speed(fishes: Fishes, library: Library, i: int, speed: float, dt: float) -> None:
    """Ease tempo and thrust toward a speed, cm/s at the recorded size and pace."""
    kind, now, wanted = fishes.species[i], fishes.segment[i], fishes.wanted_segment[i]
    own = own_speed(fishes, library, i)
    hurried = fishes.goal_speed[i] > HURRIED
    tempo, thrust = 1.0, 1.0
    if is_cstart(now) or is_cstart(wanted):
        tempo = CSTART_TEMPO
    elif BASE[wanted] == COAST:
        _coast(fishes, library, i, speed, dt)
        return
    elif BASE[wanted] == ROW:
        # Oars also turn a fish, and beat the faster the more it turns.
        least = TEMPO[0] + (1.0 - TEMPO[0]) * min(abs(float(fishes.bend[i])), 1.0)
        tempo = min(max(abs(speed) / own, least), KEEP_ROWING * ROW_TEMPO)
        thrust = min(max(speed / (tempo * own), RETREAT), 1.0)
    elif wanted == STOP:
        tempo = float(fishes.tempo[i])
        thrust = max(speed / library.speed[kind, SLOW], RETREAT) if speed < 0.0 else 0.0
        if now != STOP:  # it beats until a good row
            thrust = float(fishes.thrust[i])
    elif wanted <= FAST or wanted == BURST or BASE[wanted] == MEDIUM:
        tempo = min(max(speed / own, TEMPO[0]), TEMPO[1])
        thrust = min(max(speed / (tempo * own), RETREAT), 1.0)
    elif wanted != START:
        tempo = min(max(speed / own, TURN_TEMPO[0]), TEMPO[1] if hurried else TURN_TEMPO[1])
    faster = (BURST_EASE if hurried else TEMPO_EASE) * dt
    slower = (SLOWING if fishes.tempo[i] > 1.5 else TEMPO_EASE) * dt
    fishes.tempo[i] += np.float32(min(max(tempo - fishes.tempo[i], -slower), faster))
    if now == STOP and thrust >= 0.0:
        if library.follow[fishes.row_b[i]] == fishes.row_b[i] and wanted == STOP:
            fishes.thrust[i] -= np.float32(fishes.thrust[i] * fishes.rate[i] * dt / STAND_TIME_S)
        return
    ease = (BURST_EASE if hurried else THRUST_EASE) * dt
    fishes.thrust[i] += np.float32(min(max(thrust - fishes.thrust[i], -ease), ease))


@kernel
def _coast(fishes: Fishes, library: Library, i: int, speed: float, dt: float) -> None:
    """Slow a coasting fish by the drag of its body, and by its fins if it is much too fast.

    The tempo is its speed: 1 / tempo grows by the recorded slowing in every frame. A fish that is
    to coast beats on until a good row.
    """
    if BASE[fishes.segment[i]] != COAST:
        return
    kind, segment = fishes.species[i], fishes.segment[i]
    bent = abs(float(fishes.bend[i])) if segment != COAST else 0.0
    own = between(library.speed[kind], segment, bent)
    lost = between(library.slowing[kind], segment, bent) * fishes.rate[i] * fishes.tempo[i]
    tempo = fishes.tempo[i] / (1.0 + lost)
    if fishes.tempo[i] * own > BRAKING * speed:
        tempo -= TEMPO_EASE * dt
    fishes.tempo[i] = max(tempo, LEAST_TEMPO)


@kernel
def own_speed(fishes: Fishes, library: Library, i: int) -> float:
    """The recorded speed, cm/s, of the wanted segment of fish i, bent as much as it asks."""
    kind = fishes.species[i]
    wanted = fishes.wanted_segment[i]
    bent = abs(float(fishes.bend[i])) if blends(library, kind, wanted) else 1.0
    return between(library.speed[kind], wanted, bent)


@kernel
def _watch_monotony(fishes: Fishes, i: int, clock: Clock) -> None:
    """Time the segment; past the threshold recommend another swim at random (SMC §6.1).

    The intention generator may ignore it. The timer restarts in any case.
    """
    fishes.recommended[i] = -1
    now, wanted = fishes.segment[i], fishes.wanted_segment[i]
    if BASE[now] != BASE[wanted]:
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
def _grade(own: Array, bursts: bool, now: int, speed: float) -> int:
    """The swim whose speed is nearest to `speed`, by ratio; `own` are the recorded speeds.

    The present one is kept within a margin, but not where more than the fast one is asked for.
    """
    goal = max(speed, 0.01 * own[FAST])
    best = SLOW
    least = np.inf
    for grade in (SLOW, MEDIUM, FAST, BURST):
        if grade == BURST and (goal <= HURRIED * own[FAST] or not bursts):
            continue
        ratio = max(goal / own[grade], own[grade] / goal)
        if goal <= own[FAST] and grade == BASE[now]:
            ratio /= GRADE_MARGIN
        if ratio < least:
            best, least = grade, ratio
    return best
