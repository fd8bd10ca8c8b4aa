"""Kinematic fins and mouth: flapping, oaring, rowing, breathing (Tu §5.5, appendix B)."""

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.biomechanics.solver import TICK_S
from subsea.geometry.angles import sine_cosine, within_turn
from subsea.kernels import kernel
from subsea.motor.controller import through_water
from subsea.motor.playback import BASE, COAST, FAST, ROW, SIDES, blends
from subsea.motor.pose import TAIL_TIPS
from subsea.repertoire.blending import LEVELS
from subsea.repertoire.library import Library
from subsea.state import (
    DORSAL,
    LAG,
    LIFT_LEFT,
    MOUTH,
    PELVIC,
    SOFT,
    SWEEP_LEFT,
    TAIL,
    TWIST_LEFT,
    WAVE_COSINE,
    WAVE_SINE,
    Fishes,
)

REST_RAD = 0.55  # sweep of a relaxed fin away from the body
FLAP_RAD = 0.22  # amplitude of idle flapping
EFFORT_RAD = 0.35  # added by hard climbing, diving or turning
OAR_RAD = (0.42, 0.36)  # half axes of the cone of an oaring fin: aside and up ...
OAR_FOLDED = 0.75  # ... and by this share they shrink at full speed
SCULL_RAD = (0.45, 0.2)  # swing of a fin that sculls in an eight: aside, and up twice a beat
SCULL_TWIST_RAD = 0.6  # twist of a blade that sculls: its upper edge leads both ways
TWIST_S = 0.065  # twist of other fins over the speed of the blade: its lower edge lags
FEATHER_RAD = 1.1  # twist of a rowing fin that goes forwards, edge on
FLAP_TWIST_RAD = (1.25, 0.45)  # twist if it flaps: its upper edge leads, lower on the way down
LEAN_RAD = 0.3  # the inner fin of a turn stands off by this, the outer one is folded
STILL = 0.2  # share of the fast swim's speed: a slower fish with little thrust hovers ...
HOVER_SHARES = (0.3, 0.7)  # ... not at all, and entirely, by its share of stillness
ABREAST_HZ = 0.5  # how fast the fins come to beat together, or alternately in a hovering fish
BEAT_HZ = 1.1  # idle; a busy fin beats up to three times as fast
BRAKE_RAD = 1.2  # sweep at which the inner fin of a rowing fish stands in a turn
FOLD_RAD = 0.35  # a fast fish folds its fins to the body ...
BURST_RAD = 0.15  # ... and a bursting fish entirely, and holds them still
BURST_TEMPO = (1.3, 2.0)  # tempos at which it begins to fold them, and has folded them
ROW_RAD = (np.radians(60.0), np.radians(45.0))  # middle and half sweep of a rowing fin
ROW_LIFT_RAD = 0.36  # it goes back below and forwards above
FLAP_SWEEP_RAD = np.radians(75.0)  # sweep of a fin that rows by flapping ...
FLAP_LIFT_RAD = np.radians(50.0)  # ... up and down, half of its way
FULL_STEERING = 0.6  # rad/s: the hardest steering
HARD_STEERING = 1.5  # rad/s: steering that raises all fins
TOO_FAST = (1.5, 0.05)  # factor on the wanted speed and excess beyond which a fish brakes ...
HARD_BRAKE = 0.25  # ... and further excess, as a share of the fast swim's speed, for hard braking
BREATH_HZ = 0.8  # at rest; an effort doubles it
GAPE = 0.45  # how far the mouth opens to breathe
FOLDED = 0.3  # by this share the dorsal fin folds at full speed ...
RAISED, BURST_FOLDED = 1.1, 0.5  # ... how far it is raised, and what is left of it in a burst
SPREAD = 0.22  # spread of the tail in a hard turn or when braking
LAG_SHARE, MOST_LAG = 0.25, 0.35  # lag of the tail's edge at the fast swim's speed; greatest
CLOSED = 0.12  # how far the tail closes in a glide and at full speed
SPREAD_SPEED = 0.5  # share of the fast swim's: a slower fish spreads its pelvic fins
EASE_HZ = 3.0  # how fast dorsal fin, pelvic fins and tail follow ...
BURST_EASE = 3.0  # ... and how much faster in a burst
WAVE = 0.14  # amplitude of a median fin's edge, over the length of its rays
STIFFER, LITTLE = 0.45, 0.15  # shares of the wave without rowing, and at full speed
WAVE_HZ = (1.8, 4.0)  # at rest, and in a turn, when braking or at full speed
MOST_WAVE_RAD = 1.3  # per tick: faster waves could not be interpolated
WAVING_SPEED = 0.6  # share of the fast swim's: without rowing, a faster fish waves little


@kernel
def flap(who: Ints, fishes: Fishes, library: Library, dt: float) -> None:
    """Advance fins and breath of the fishes `who` by one tick."""
    for i in who:
        _flap_once(fishes, library, i, dt)


@kernel
def flap_in_turn(who: Ints, fishes: Fishes, library: Library, due: Bools, dt: float) -> None:
    """Advance fins and breath of those of the fishes `who` that are `due` (n,); others rest.

    A fish whose fins rested makes up for these ticks first.
    """
    for i in who:
        rested = int(fishes.rested[i])
        if due[i]:
            if rested > 0:
                _advance(fishes, library, i, rested * dt)
                fishes.rested[i] = 0
            _flap_once(fishes, library, i, dt)
        elif fishes.alive[i]:
            fishes.rested[i] = rested + 1


@kernel
def _flap_once(fishes: Fishes, library: Library, i: int, dt: float) -> None:
    """Advance fins and breath of fish i by one tick."""
    for column in range(fishes.fins.shape[1]):
        fishes.previous_fins[i, column] = fishes.fins[i, column]
    _advance(fishes, library, i, dt)


@kernel
def _advance(fishes: Fishes, library: Library, i: int, dt: float) -> None:
    """Advance fins and breath of fish i by `dt` s."""
    fins, phase, breath = fishes.fins[i], fishes.fin_phase[i], float(fishes.breath[i])
    fishes.breath[i] = _beat(fishes, library, i, dt, fins, phase, breath)


@kernel
def fins_at(
    fishes: Fishes, library: Library, i: int, alpha: float, fins: Array, phase: Array
) -> None:
    """Write the fins (columns,) float32 of fish i at share `alpha` of the present tick.

    Fins that rest are drawn where they would be if they did not. `phase` (3,) float32 is memory.
    """
    before, after, rested = fishes.previous_fins[i], fishes.fins[i], int(fishes.rested[i])
    if rested == 0:
        for column in range(len(fins)):
            fins[column] = (1.0 - alpha) * before[column] + alpha * after[column]
        return
    for column in range(len(fins)):
        fins[column] = after[column]
    for k in range(len(phase)):
        phase[k] = fishes.fin_phase[i, k]
    since_s = (rested - 1 + alpha) * TICK_S
    _beat(fishes, library, i, since_s, fins, phase, float(fishes.breath[i]))


@kernel
def _beat(
    fishes: Fishes, library: Library, i: int, dt: float, fins: Array, phase: Array, breath: float
) -> float:
    """Advance `fins` (columns,) and their `phase` (3,) of fish i by `dt` s; return its breath.

    Flapping is a·sin(b·t), where a and b grow with the effort (Tu B.1). Flat-bodied fishes oar:
    each fin sweeps a cone forwards, or backwards on the inner side of a turn and on both sides to
    brake or retreat (Tu B.2). While a row of the pectoral gait is played, its phase is that of the
    fins: foremost at the beginning of the stroke, or highest if they flap. A hovering fish sculls
    with both alternately.
    """
    steering = fishes.steering[i, 0]
    effort = min((abs(steering) + abs(fishes.steering[i, 1])) / FULL_STEERING, 1.0)
    speed = min(max(np.float64(fishes.goal_speed[i]), 0.0), 1.0)
    turning = steering / FULL_STEERING + _turn_share(fishes, library, i)
    turning = min(max(turning, -1.0), 1.0)
    braking = min(max(1.0 - np.float64(fishes.thrust[i]), 0.0), 1.0)

    # Oars beat faster in a faster fish (Tu B.2); other fins scull while it hovers.
    busy = max(effort, speed if fishes.oars[i] else 1.0 - speed)
    pace = 2.0 * np.pi * BEAT_HZ * (1.0 + 2.0 * busy)
    stride = pace * fishes.size_rate[i] * dt
    rows, stroke = _stroke(fishes, library, i)
    low, high = BURST_TEMPO
    burst = min(max((float(fishes.tempo[i]) - low) / (high - low), 0.0), 1.0) * (1.0 - rows)
    held = REST_RAD - FOLD_RAD * speed - BURST_RAD * burst
    lean = (1.0 - burst) * LEAN_RAD * turning
    way = through_water(fishes, i) / max(float(fishes.fast[i]), 1e-3)
    least, most = HOVER_SHARES
    hover = (braking * max(1.0 - way / STILL, 0.0) - least) / (most - least)
    hover = min(max(hover, 0.0), 1.0)
    apart = phase[1] - phase[0]
    gap = within_turn(hover * np.pi - apart + np.pi) - np.pi
    abreast = min(2.0 * np.pi * ABREAST_HZ * dt, 1.0) * (1.0 - abs(turning))
    phase[1] += abreast * gap
    for side in range(2):
        inner = max(turning, 0.0) if side == 0 else max(-turning, 0.0)
        forwards = (1.0 - 2.0 * inner) * (1.0 - braking) - braking
        turned = forwards if fishes.oars[i] else 1.0
        angle = phase[side] + turned * stride
        phase[side] = within_turn(angle)
        sine, cosine = sine_cosine(angle)
        if fishes.oars[i]:
            kept = 1.0 - OAR_FOLDED * speed * speed
            reach, lift = kept * OAR_RAD[0], kept * OAR_RAD[1] * cosine
        else:
            reach, lift = FLAP_RAD + EFFORT_RAD * effort, 0.0
        reach = (1.0 - burst) * (reach + hover * (SCULL_RAD[0] - reach))
        lift += hover * (SCULL_RAD[1] * 2.0 * sine * cosine - lift)
        sweep = held + reach * sine + (lean if side == 0 else -lean)
        flex = TWIST_S * pace * reach
        flex += hover * (SCULL_TWIST_RAD - flex)
        twist = turned * flex * cosine
        if rows > 0.0:
            middle, reach = ROW_RAD
            rowing, raised = middle + reach * np.cos(stroke), -ROW_LIFT_RAD * np.sin(stroke)
            feather = 0.5 * FEATHER_RAD * (1.0 - np.sin(stroke))
            if fishes.flaps[i]:
                rowing, raised = FLAP_SWEEP_RAD, FLAP_LIFT_RAD * np.cos(stroke)
                feather = FLAP_TWIST_RAD[0] + FLAP_TWIST_RAD[1] * np.sin(stroke)
            # The outer fin strokes, and the inner one brakes broadside.
            rowing += inner * (BRAKE_RAD - rowing)
            share = (1.0 - hover) * rows
            sweep += share * (rowing - sweep)
            lift += share * ((1.0 - inner) * raised - lift)
            twist += share * ((1.0 - inner) * feather - twist)
        fins[SWEEP_LEFT + side] = sweep
        fins[LIFT_LEFT + side] = lift
        fins[TWIST_LEFT + side] = twist

    panting = max(effort, speed)
    breath += 2.0 * np.pi * BREATH_HZ * fishes.size_rate[i] * (1.0 + panting) * dt
    fins[MOUTH] = max(GAPE * 0.5 * (1.0 - sine_cosine(breath)[1]), np.float64(fishes.gape[i]))
    ease = min(EASE_HZ * (1.0 + BURST_EASE * burst) * dt, 1.0)
    brake = (way - TOO_FAST[0] * speed - TOO_FAST[1]) / HARD_BRAKE
    turn = max(abs(_turn_share(fishes, library, i)), abs(steering) / HARD_STEERING)
    # The effort of a turn or of braking raises and spreads its fins.
    effort = min(max(turn, brake, 0.0), 1.0)
    _raise(fishes, i, fins, speed, effort, burst, ease)
    calm = max(rows, 1.0 - speed / WAVING_SPEED) * (1.0 - burst)
    rate = WAVE_HZ[0] + (WAVE_HZ[1] - WAVE_HZ[0]) * max(effort, speed)
    wide = WAVE * (LITTLE * (1.0 - burst) + (1.0 - LITTLE) * max(calm, 0.0))
    if not library.has[fishes.species[i], ROW]:
        wide *= STIFFER
    _wave(fishes, i, fins, phase, wide, rate, ease, dt)
    across = _stroke_of_tail(fishes, library, i) / max(library.speed[fishes.species[i], FAST], 1e-3)
    fins[LAG] = -min(max(LAG_SHARE * across, -MOST_LAG), MOST_LAG)
    return within_turn(breath)


@kernel
def _raise(
    fishes: Fishes, i: int, fins: Array, speed: float, effort: float, burst: float, ease: float
) -> None:
    """Ease dorsal, ventral, caudal and pelvic `fins` of fish i; the soft rays lag.

    `effort` is that of a turn or of braking, `ease` the share of the way in this time.
    """
    raised = max(effort, np.float64(fishes.raised[i]))
    erect = 1.0 - FOLDED * speed * speed
    erect += raised * (RAISED - erect)
    erect += burst * (BURST_FOLDED - erect)
    fins[SOFT] += ease * (fins[DORSAL] - fins[SOFT])
    fins[DORSAL] += ease * (erect - fins[DORSAL])
    coasts = fishes.span[i] > 1.0 or BASE[fishes.segment[i]] == COAST
    glides = 1.0 if coasts else speed * speed
    fins[TAIL] += ease * (SPREAD * effort - CLOSED * glides * (1.0 - effort) - fins[TAIL])
    spread = max(1.0 - speed / SPREAD_SPEED, effort) * (1.0 - burst)
    fins[PELVIC] += ease * (spread - fins[PELVIC])


@kernel
def _wave(
    fishes: Fishes, i: int, fins: Array, phase: Array, wide: float, rate: float, ease: float,
    dt: float,
) -> None:  # fmt: skip
    """Advance the wave of dorsal and ventral fin of fish i: rearwards, but forwards in a retreat.

    `wide` is the amplitude to which it eases, `rate` that of a fish of the recorded size, Hz.
    """
    turn = 2.0 * np.pi * (rate * dt) * fishes.size_rate[i]
    turn = min(turn, MOST_WAVE_RAD * (dt / TICK_S))
    angle = phase[2] + (turn if fishes.thrust[i] >= 0.0 else -turn)
    phase[2] = within_turn(angle)
    now = np.sqrt(fins[WAVE_SINE] ** 2 + fins[WAVE_COSINE] ** 2)
    amplitude = now + ease * (wide - now)
    sine, cosine = sine_cosine(angle)
    fins[WAVE_SINE], fins[WAVE_COSINE] = amplitude * sine, amplitude * cosine


@kernel
def _stroke_of_tail(fishes: Fishes, library: Library, i: int) -> float:
    """Measure how fast the tail of fish i moves to its right, cm/s of the recorded fish."""
    way = 0.0
    for tip in TAIL_TIPS:
        way += library.nodes[fishes.row_b[i], tip, 2] - library.nodes[fishes.row_a[i], tip, 2]
    return 0.5 * way / TICK_S * fishes.tempo[i] / fishes.span[i]


@kernel
def _turn_share(fishes: Fishes, library: Library, i: int) -> float:
    """How hard the segment of fish i turns: from -1, to the right, to 1."""
    segment, row = fishes.segment[i], fishes.row_b[i]
    if blends(library, fishes.species[i], segment) and row < len(library.level):
        return library.level[row] / LEVELS
    return float(SIDES[segment])


@kernel
def _stroke(fishes: Fishes, library: Library, i: int) -> tuple[float, float]:
    """Share of the pectoral gait in the pose of fish i, and its phase, rad; back in a retreat."""
    kind, a, b = fishes.species[i], fishes.row_a[i], fishes.row_b[i]
    first, length = library.first[kind, ROW], library.length[kind, ROW]
    if b < len(library.straight):
        a, b = library.straight[a], library.straight[b]
    from_row, to_row = first <= a < first + length, first <= b < first + length
    if not (library.has[kind, ROW] and (from_row or to_row)):
        return 0.0, 0.0
    weight = float(fishes.weight[i])
    if not to_row:
        share, place = 1.0 - weight, float(a - first)
    elif not from_row:
        share, place = weight, float(b - first)
    else:
        share, place = 1.0, a - first + weight
    phase = 2.0 * np.pi * (place + 1.0) / length  # a row is the pose at its end
    return share, phase if fishes.thrust[i] >= 0.0 else -phase
