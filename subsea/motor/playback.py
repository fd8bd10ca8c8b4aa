"""Play recorded motion and glides (SMC §5.1, §5.2), one pass per tick.

The codes of `repertoire.schema.SEGMENTS` are plain numbers for compiled kernels.
"""

import numpy as np

from subsea.base.arrays import Array, Ints
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
from subsea.kernels import kernel
from subsea.motor.containment import balanced
from subsea.repertoire import SEGMENTS
from subsea.repertoire.blending import LEVELS, TIGHTEST
from subsea.repertoire.library import Library
from subsea.repertoire.schema import FAMILIES
from subsea.state import Fishes

SLOW, MEDIUM, FAST, LEFT_GRADUAL, LEFT_SHARP, RIGHT_GRADUAL, RIGHT_SHARP = range(7)
BURST = SEGMENTS.index("swim_burst")
CSTARTS = range(SEGMENTS.index("cstart_left_moderate"), SEGMENTS.index("cstart_right_wide") + 1)
FIRST_CSTART, LAST_CSTART = CSTARTS[0], CSTARTS[-1]
LEFT_REST = SEGMENTS.index("turn_left_rest")
LEFT_GLIDE = SEGMENTS.index("turn_left_glide")
START, STOP = SEGMENTS.index("swim_start"), SEGMENTS.index("swim_stop")
ROW = SEGMENTS.index("row_forward")
COAST = SEGMENTS.index("swim_coast")
# The side to which each segment turns: 1 left, -1 right, 0 none.
SIDES = np.array([("left" in name) - float("right" in name) for name in SEGMENTS])
# The straight swim of a segment's family, or the segment itself; and its turns, -1 for none.
BASE, TURNS = np.arange(len(SEGMENTS)), np.full((len(SEGMENTS), 2), -1)
for _straight, _names in FAMILIES.items():
    _code = SEGMENTS.index(_straight)
    TURNS[_code] = [SEGMENTS.index(name) for name in _names]
    BASE[TURNS[_code]] = _code


@kernel
def is_cstart(segment: int) -> bool:
    """True for an escape."""
    return FIRST_CSTART <= segment <= LAST_CSTART


@kernel
def blends(library: Library, kind: int, segment: int) -> bool:
    """True for a straight swim and its turns that blend with it row by row."""
    turn = TURNS[BASE[segment], 0]
    return turn >= 0 and library.veer[kind, turn] >= 0


TEMPO = (0.4, 3.0)  # range of a segment's rate, to meet a speed at the recorded stride
HASTE = 1.3  # tempo at which a fish that was faster begins a segment
HURRIED = 1.0  # goal speed above which a fish does not wait for a good row
SUDDEN = 3.0  # frames of a glide to an escape from a row without a plan
LEVEL_PHASE = 12  # part of a beat in which the bend changes by a level
MOST_BEGUN = 1  # largest level of bend to which other segments glide
LEAST_TEMPO = 0.05  # of a coast, whose tempo is its speed
AT_REST = 0.3  # share of the slow swim's pace below which a segment begins at rest


@kernel
def play(who: Ints, fishes: Fishes, library: Library, dt: float) -> None:
    """Advance the fishes `who` by one tick of recorded motion, steering, balance and drift.

    Simulated fishes have already moved (`motor/dynamics.py`).
    """
    per_second = 1.0 / dt
    for i in who:
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
        q = normalised(balanced(fishes, i, q, library.bank[fishes.row_b[i]], dt))
        for axis in range(3):
            place = o[axis] + fishes.drift[i, axis] * dt
            fishes.velocity[i, axis] = (place - fishes.position[i, axis]) * per_second
            fishes.position[i, axis] = place
        store(fishes.orientation[i], q)


@kernel
def advance(fishes: Fishes, library: Library, i: int) -> tuple[Vector, Quaternion]:
    """Play fish i for one tick: its new origin and orientation.

    R ← R·M, o ← o + R·αt (SMC eqs. 10, 11). A fraction f of a row moves by M^f and f t, so that
    the fractions of a row add up to it. A held row lets the body drift ahead: thrust is its speed
    over that of the slow swim. Advances row a, row b, weight, span and segment in place.
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
        elif a == b:
            rotation = (1.0, 0.0, 0.0, 0.0)
            shift = (float(library.pace[fishes.species[i], SLOW, 0]), 0.0, 0.0)
        elif weight > 0.0:
            # Translations are recorded in the axes that the row began with.
            shift = rotate(fraction(rotation, -weight), shift)
        step = rotate(q, shift)
        o = plus(o, times(frames * fishes.scale[i] * thrust, step))
        turned = rotation if frames == 1.0 else fraction(rotation, frames)
        q = multiply(q, turned)
        if gliding and _keeps_course(fishes, library, i):
            # The head of a beat sways about the course, that of a coast does not.
            swayed = float(library.sway[b] - library.sway[a]) * frames / span
            yawed = 2.0 * turned[2] * np.sign(turned[0])
            q = multiply(q, about(0.0, 1.0, 0.0, swayed - yawed))
        if library.facing[a] != library.facing[b]:
            # As the body bends its head turns inwards, and the fish keeps its way.
            inwards = float(library.facing[b] - library.facing[a]) * frames / span
            q = multiply(q, about(0.0, 1.0, 0.0, inwards))
        left -= frames / rate
        weight += frames / span
        if until_b <= frames:
            weight = 0.0
            _next_row(fishes, library, i)
    fishes.weight[i] = weight
    return o, q


@kernel
def _keeps_course(fishes: Fishes, library: Library, i: int) -> bool:
    """True in a glide between a straight beat and a straight coast."""
    kind, a, b = fishes.species[i], fishes.row_a[i], fishes.row_b[i]
    if a >= len(library.level) or library.level[a] != 0 or library.level[b] != 0:
        return False
    first, length = library.first[kind, COAST], library.length[kind, COAST]
    coasts = first <= a < first + length, first <= b < first + length
    return bool(library.has[kind, COAST]) and coasts[0] != coasts[1]


@kernel
def _next_row(fishes: Fishes, library: Library, i: int) -> None:
    """Make row b row a, and choose the next row b: change the segment or the bend, or play on."""
    kind, a = fishes.species[i], fishes.row_b[i]
    before, fishes.row_a[i] = fishes.row_a[i], a
    fishes.span[i] = 1.0
    at_end = library.follow[a] == a
    if _changes_segment(fishes, library, i, at_end):
        _change_segment(fishes, library, i, before, at_end)
    elif blends(library, kind, fishes.segment[i]):
        _change_bend(fishes, library, i)
    else:
        fishes.row_b[i] = library.follow[a]
        if at_end and before != a:
            # A held row drifts at its thrust, over the slow swim.
            fishes.thrust[i] *= (
                fishes.tempo[i]
                * library.pace[kind, fishes.segment[i], 1]
                / library.pace[kind, SLOW, 0]
            )
            fishes.tempo[i] = 1.0


@kernel
def _changes_segment(fishes: Fishes, library: Library, i: int, at_end: bool) -> bool:
    """Decide whether fish i leaves its segment at row a.

    Between a straight swim and its turns the bend changes level by level. A body that is bent goes
    on to swims that bend; other segments are entered and left with a nearly straight one.
    """
    kind, a = fishes.species[i], fishes.row_a[i]
    now, wanted = fishes.segment[i], fishes.wanted_segment[i]
    if is_cstart(wanted) and not is_cstart(now):
        return True
    blended = blends(library, kind, wanted)
    if blended and BASE[now] == BASE[wanted]:
        return False
    good = library.leave[a, BASE[wanted] if blended else wanted]
    if library.cyclic[kind, now]:
        straight = blended or abs(library.level[a]) <= MOST_BEGUN
        return wanted != now and ((straight and good) or fishes.goal_speed[i] > HURRIED)
    return (good or at_end) and (wanted != now or (at_end and now != STOP))


@kernel
def _change_segment(fishes: Fishes, library: Library, i: int, before: int, at_end: bool) -> None:
    """Glide from row a to the entry of the wanted segment, at the speed so far."""
    kind, a = fishes.species[i], fishes.row_a[i]
    now, wanted = fishes.segment[i], fishes.wanted_segment[i]
    blended = blends(library, kind, wanted)
    goal = BASE[wanted] if blended else wanted
    fishes.row_b[i] = library.entry[a, goal]
    planned = library.cyclic[kind, now] or at_end or library.has[kind, wanted]
    fishes.span[i] = library.glide[a, goal] if planned else SUDDEN
    fishes.segment[i] = wanted
    if blended:
        held = library.level[a] if blends(library, kind, now) else 0
        level = min(max(_asked(fishes, i), held - MOST_BEGUN), held + MOST_BEGUN)
        _bend(fishes, library, i, fishes.row_b[i], level)
    fishes.glide_tempo[i] = fishes.tempo[i]
    fishes.glide_thrust[i] = fishes.thrust[i]
    share = _bent(library, kind, now, a)
    bent = _bent(library, kind, wanted, fishes.row_b[i])
    slow = library.pace[kind, SLOW, 0]
    out = slow if before == a else between(library.pace[kind, :, 1], now, share)
    into = between(library.pace[kind, :, 0], wanted, bent)
    own = between(library.speed[kind], wanted, bent)
    quick = fishes.goal_speed[i] * library.speed[kind, FAST] / own
    _keep_speed(fishes, i, out / max(into, AT_REST * slow), into >= AT_REST * slow, quick)


@kernel
def _change_bend(fishes: Fishes, library: Library, i: int) -> None:
    """Go on in a straight swim or its turn, a level nearer to the bend that is asked for."""
    kind, a = fishes.species[i], fishes.row_a[i]
    level, row = library.level[a], library.straight[a]
    asked = _asked(fishes, i)
    change = min(max(asked - level, -1), 1)
    if BASE[fishes.segment[i]] != MEDIUM and asked != 0 and abs(asked - level) == 1:
        change = 0  # without a beat the head turns with the bend at once: else it would waver
    rows = max(library.length[kind, MEDIUM] // LEVEL_PHASE, 1) if change else 1
    for _ in range(rows):
        row = library.follow[row]
    fishes.span[i] = rows
    fishes.glide_tempo[i], fishes.glide_thrust[i] = fishes.tempo[i], fishes.thrust[i]
    _bend(fishes, library, i, row, level + change)


@kernel
def between(own: Array, segment: int, bent: float) -> float:
    """A property of the segments `own` (n,), at a share of the bend of a turn."""
    return float((1.0 - bent) * own[BASE[segment]] + bent * own[segment])


@kernel
def _bent(library: Library, kind: int, segment: int, row: int) -> float:
    """The bend at a row of a segment, as a share of its turn's."""
    return abs(library.level[row]) / LEVELS if blends(library, kind, segment) else 1.0


@kernel
def _asked(fishes: Fishes, i: int) -> int:
    """The level of bend that the controller asks for; the recorded turn if it names no bend."""
    wanted = fishes.wanted_segment[i]
    if BASE[wanted] == wanted:
        return 0
    asked = round(abs(float(fishes.bend[i])) * LEVELS)
    asked = min(int(asked), TIGHTEST) if fishes.bend[i] != 0.0 else LEVELS
    return asked if SIDES[wanted] > 0.0 else -asked


@kernel
def _bend(fishes: Fishes, library: Library, i: int, row: int, level: int) -> None:
    """Make row b the one at the phase of `row`, bent by `level`, and name its segment."""
    kind, base = fishes.species[i], BASE[fishes.segment[i]]
    straight = library.straight[row]
    if level == 0:
        fishes.row_b[i], fishes.segment[i] = straight, base
        return
    turn = TURNS[base, 0 if level > 0 else 1]
    phase = straight - library.first[kind, base]
    behind = (abs(level) - 1) * library.length[kind, base] + phase
    fishes.row_b[i] = library.veer[kind, turn] + behind
    fishes.segment[i] = turn


@kernel
def _keep_speed(fishes: Fishes, i: int, ratio: float, moving: bool, quick: float) -> None:
    """Keep the speed in a new segment; `ratio` is the old recorded pace over the new one.

    The tempo takes up what it can, up to `quick` or a little haste, and the thrust the rest: a
    fish that slows down coasts. The controller then eases both toward the goal. A segment that
    does not begin `moving` has its own speed. The tempo of a coast is its speed.
    """
    if not moving or is_cstart(fishes.segment[i]):
        fishes.thrust[i] = 1.0
        return
    exact = fishes.tempo[i] * ratio
    if BASE[fishes.segment[i]] == COAST:
        fishes.tempo[i] = max(exact * max(fishes.thrust[i], 0.0), LEAST_TEMPO)
        fishes.thrust[i] = 1.0
        return
    most = min(max(quick, HASTE), TEMPO[1])
    fishes.tempo[i] = min(max(exact, TEMPO[0]), most)
    fishes.thrust[i] *= exact / fishes.tempo[i]


@kernel
def _steer(q: Quaternion, yaw: float, pitch: float) -> Quaternion:
    """Turn left by `yaw` about the world's vertical and raise the nose by `pitch`, rad."""
    q = multiply(about(0.0, 0.0, 1.0, yaw), q)
    return multiply(q, about(0.0, 0.0, 1.0, pitch))
