"""Record a boxfish: a stiff body that its pectoral fins row (ostraciiform, labriform).

All grades are strokes of both fins, at other frequencies; thrust and drag give the speed. Turns
follow a rule: the water of slender bodies resists the yaw of a stiff one far more than that of a
box, which turns nearly on the spot, by up to 218° a second (Walker 2000; recalled).
"""

import math
from typing import Any

import msgspec
import numpy as np

from capture.recording.record import Recorded, motion_of
from capture.recording.record import assemble as assemble_bending
from subsea.biomechanics.body import Floats, build_body, to_world
from subsea.biomechanics.coasting import COAST_TICKS
from subsea.biomechanics.controllers import ease
from subsea.biomechanics.manoeuvres import BACKING, MIRROR
from subsea.biomechanics.rowing import Oars, balanced_speed, oars_of, row_stroke, row_ticks
from subsea.biomechanics.solver import STEPS_PER_TICK, TICK_TU
from subsea.fish.species import Species
from subsea.repertoire import SEGMENTS, Repertoire
from subsea.repertoire.schema import ACYCLIC, BASIC_SEGMENTS
from subsea.repertoire.segments import make_segment

SOURCE = "boxfish"
SLOWER = {"slow": 1.6, "medium": 1.0, "fast": 0.7, "burst": 0.5}  # ticks of a stroke over [row]
FEWEST_TICKS = 4
GRADUAL_DEG = 12.0  # of heading in a stroke of a gradual turn
SHARP_DEG, SHARP_STROKES = 90.0, 4
MOST_STROKES = 40  # of a start
STARTED, STOPPED = 0.9, 0.1  # shares of the speed of medium at which a start and a stop end
PER_TICK = 4 * STEPS_PER_TICK  # steps of a stroke
ROWED = ("swim_burst", "swim_start", "swim_stop", "swim_coast", "row_forward")


def segments_of(species: Species) -> tuple[str, ...]:
    """The segments of a boxfish: it makes no escapes, as it cannot bend."""
    names = {*BASIC_SEGMENTS, *ROWED, "turn_left_row", "turn_right_row"}
    return tuple(name for name in SEGMENTS if name in names)


def record_segment(species: Species, name: str) -> Recorded:
    """Record one segment."""
    body, length = build_body(motion_of(species).body), species.length_cm
    kind, _, grade = name.rpartition("_")
    steps, slowing = _turn(species, grade) if "turn" in kind else _straight(species, grade)
    place, rotation = _path(steps)
    rest = np.repeat(body.rest[None], len(place), axis=0)
    frames = np.asarray(to_world(rest, place, rotation), np.float64)
    if "right" in name:
        frames = frames[:, MIRROR] * (1.0, 1.0, -1.0)
    segment = make_segment(
        frames, length,
        pattern="left" if "left" in name else "right" if "right" in name else "forward",
        grade=grade, cyclic=grade not in ACYCLIC, slowing=slowing,
    )  # fmt: skip
    return Recorded(segment)


def assemble(name: str, species: Species, recorded: dict[str, Recorded]) -> Repertoire:
    """Make a repertoire of recorded segments."""
    made = assemble_bending(name, species, recorded)
    fields: dict[str, Any] = {key: getattr(made, key) for key in made.__dataclass_fields__}
    return Repertoire(**fields | {"source": SOURCE})


def _oars(species: Species, grade: str) -> tuple[Oars, int]:
    """The fins that drive a species at a grade, and the ticks of a stroke."""
    row, fin, length = species.row, species.surface.pectoral, species.length_cm
    if not (row and fin):
        raise ValueError(f"{species.name} does not row")
    ticks = max(FEWEST_TICKS, round(SLOWER.get(grade, 1.0) * row.ticks_per_stroke))
    plan = msgspec.structs.replace(row, ticks_per_stroke=ticks)
    body = build_body(motion_of(species).body)
    return oars_of(body, plan, (fin.length * length, fin.width * length)), ticks


def _straight(species: Species, grade: str) -> tuple[Floats, float]:
    """The steps (T, 3) of a straight motion: ahead and right, cm, and rad; and its slowing."""
    oars, ticks = _oars(species, grade)
    speed, slowing = balanced_speed(oars), 0.0
    if grade == "coast":
        ways = np.full(COAST_TICKS, speed * TICK_TU)
        slowing = oars.drag / oars.mass * speed * TICK_TU
    elif grade == "start":
        ways = _start(*_oars(species, "burst"), speed)
    elif grade == "stop":
        ways = _stop(oars, speed)
    else:
        row, fin = species.row, species.surface.pectoral
        assert row and fin
        size = fin.length * species.length_cm, fin.width * species.length_cm
        plan = msgspec.structs.replace(row, ticks_per_stroke=ticks)
        ways = row_ticks(build_body(motion_of(species).body), plan, size)
    steps = np.zeros((len(ways), 3))
    steps[:, 0] = ways
    return steps, slowing


def _start(oars: Oars, ticks: int, usual: float) -> Floats:
    """Ways (T,), cm, of the ticks of quick strokes from rest."""
    speed, ways = 0.0, list[float]()
    for _ in range(MOST_STROKES):
        speeds = row_stroke(oars, speed, ticks * PER_TICK)
        mean = 0.5 * (speeds[1:] + speeds[:-1])
        ways.extend(mean.reshape(ticks, PER_TICK).mean(axis=1) * TICK_TU)
        speed = float(speeds[-1])
        if mean.mean() >= STARTED * usual:
            break
    return np.array(ways)


def _stop(oars: Oars, usual: float) -> Floats:
    """Ways (T,), cm, of the ticks in which both fins row backwards, as those of other fishes."""
    area = 2.0 * 0.25 * math.pi * oars.length * oars.width
    speed, ways, step = usual, list[float](), TICK_TU / PER_TICK
    while speed > STOPPED * usual:
        way = 0.0
        for _ in range(PER_TICK):
            way += step * speed
            push = area * (speed + BACKING * usual) ** 2 + oars.drag * speed**2
            speed = max(speed - step * push / oars.mass, 0.0)
        ways.append(way)
    return np.array(ways)


def _turn(species: Species, grade: str) -> tuple[Floats, float]:
    """The steps (T, 3) of a turn to the left by strokes of medium."""
    steps, slowing = _straight(species, "medium")
    if grade == "sharp":
        steps = np.tile(steps, (SHARP_STROKES, 1))
        heading = SHARP_DEG * ease(np.arange(len(steps) + 1) / len(steps))
    else:
        heading = np.linspace(0.0, GRADUAL_DEG, len(steps) + 1)
    steps[:, 2] = np.radians(np.diff(heading))
    return steps, slowing


def _path(steps: Floats) -> tuple[Floats, Floats]:
    """Places (T + 1, 3) and rotations (T + 1, 3, 3) after steps (T, 3) in the axes of the body."""
    heading = np.concatenate([[0.0], np.cumsum(steps[:, 2])])
    c, s = np.cos(heading), np.sin(heading)
    zero = np.zeros(len(heading))
    # The columns are the axes of the body: ahead, up and right.
    rotation = np.stack([c, zero, s, zero, zero + 1.0, zero, -s, zero, c], axis=1)
    rotation = rotation.reshape(-1, 3, 3)
    local = np.stack([steps[:, 0], zero[1:], steps[:, 1]], axis=1)
    moved = np.einsum("tij,tj->ti", rotation[:-1], local)
    return np.concatenate([np.zeros((1, 3)), np.cumsum(moved, axis=0)]), rotation
