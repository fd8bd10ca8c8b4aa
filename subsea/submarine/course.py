"""Tours of a scenario: a path through waypoints, with gaze targets."""

import math
from typing import NamedTuple

import msgspec
import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.base.disk_cache import cached
from subsea.base.errors import UserError, unknown
from subsea.geometry.curve import Curve, curve_at, curve_through
from subsea.geometry.height_field import height_at
from subsea.geometry.solids import from_pillar, from_rock
from subsea.geometry.vector import vector
from subsea.scenario.schema import AUTOPILOT, Bounds, Scenario, TourTable, Waypoint
from subsea.state import HULL_CM, Sea, State
from subsea.submarine.hull import AHEAD_CM_S
from subsea.submarine.rail import Rail

AHEAD_S = 2.0  # how far along the path a tour that looks ahead looks
NEAR_CM = 250.0  # scale of the distance that weights followed fishes
PROBE_S = 0.1  # interval at which a path is checked


class Course(NamedTuple):
    """A tour that is ready to run."""

    curve: Curve
    gaze_s: Array  # (g,) times of the gaze targets ...
    gazes: tuple[Waypoint, ...]  # ... of these waypoints
    species: tuple[str, ...]  # in the order of `Fishes.species`

    @property
    def seconds(self) -> float:
        """Duration of the tour, or of one round."""
        return float(self.curve.times[-1])


def course_of(scenario: Scenario, name: str) -> Course:
    """The tour `name` of a scenario; an unknown name is a UserError."""
    tours = {tour.name: tour for tour in scenario.tour}
    if name not in tours:
        raise unknown("tour", name, [AUTOPILOT, *tours])
    return _course(tours[name], scenario)


def rail_at(course: Course, state: State, t: float) -> Rail:
    """Position and gaze `t` seconds after the start, in the present sea."""
    place, velocity = curve_at(course.curve, t)
    if course.curve.loop:
        t %= course.seconds
    k = int(np.searchsorted(course.gaze_s, t, side="right"))
    before, after = max(k - 1, 0), min(k, len(course.gazes) - 1)
    heading, pitch = _toward(course, course.gazes[before], state, place, t)
    if course.gaze_s[after] > course.gaze_s[before]:
        share = (t - course.gaze_s[before]) / (course.gaze_s[after] - course.gaze_s[before])
        share = _eased(min(max(share, 0.0), 1.0))
        other, steep = _toward(course, course.gazes[after], state, place, t)
        heading += share * math.remainder(other - heading, math.tau)
        pitch += share * (steep - pitch)
    return Rail(place, velocity, (heading, pitch))


def paths_of(scenario: Scenario) -> Array:
    """The paths of all tours as lines (n, 2, 3), cm."""
    lines = [np.zeros((0, 2, 3))]
    for tour in scenario.tour:
        curve = _course(tour, scenario).curve
        places = [curve_at(curve, t)[0] for t in np.arange(0.0, curve.times[-1], 5.0 * PROBE_S)]
        lines.append(np.stack([places[:-1], places[1:]], axis=1))
    return np.concatenate(lines)


def check_tours(scenario: Scenario, sea: Sea, rocks: list[str], stored: bool = True) -> None:
    """Raise a UserError for a tour that leaves the sea, is too near solids, or too fast.

    `rocks` are the names of the rocks of the sea. `stored`: use the disk cache.
    """
    curves = [_course(tour, scenario).curve for tour in scenario.tour]
    given = curves, sea, scenario.bounds, rocks
    fault = cached(_first_fault, *given) if stored else _first_fault(*given)
    if fault is not None:
        k, t, what = fault
        leg = int(np.searchsorted(curves[k].times, t, side="right")) - 1
        raise UserError(
            f"`tour[{k}]` {scenario.tour[k].name!r} {what}, {t:.1f} s after its start, "
            f"between `waypoint[{leg}]` and `waypoint[{leg + 1}]`",
            key=f"tour[{k}]",
        )


def _first_fault(
    curves: list[Curve], sea: Sea, bounds: Bounds, rocks: list[str]
) -> tuple[int, float, str] | None:
    """The first fault of any course: its index, the time in seconds, and a message."""
    for k, curve in enumerate(curves):
        times = np.arange(0.0, curve.times[-1], PROBE_S).tolist()
        path = [curve_at(curve, t) for t in times]
        near = _near_rocks(np.array([place for place, _ in path]), sea)
        beside = sea._replace(rocks=sea.rocks[near])
        names = [rocks[number] for number in near.tolist()]
        for t, (place, velocity) in zip(times, path, strict=True):
            if fault := _fault(place, velocity, beside, bounds, names):
                return k, t, fault
    return None


def _near_rocks(places: Array, sea: Sea) -> Ints:
    """Indices of the rocks that may lie within `HULL_CM` of a place (n, 3), by `from_rock`."""
    half = sea.rocks[:, 3:6]
    # Farther away the distance is larger, also where it is only approximate: see `far_from_rock`.
    reach = half.max(axis=1) * (1.0 + HULL_CM / half.min(axis=1))
    away = np.linalg.norm(places[:, None] - sea.rocks[:, :3], axis=2).min(axis=0)
    return np.flatnonzero(away <= reach + 1.0)


def _course(tour: TourTable, scenario: Scenario) -> Course:
    times = np.array([point.time_s for point in tour.waypoint])
    places = np.array([point.position_cm for point in tour.waypoint])
    looking = [point for point in tour.waypoint if point.looks]
    looking = looking or [msgspec.structs.replace(tour.waypoint[0], ahead=True)]
    if tour.loop:  # the last gaze is the first
        first, last = looking[0], looking[-1]
        period = float(times[-1])
        looking = [_later(last, -period), *looking, _later(first, period)]
    return Course(
        curve_through(times, places, tour.loop),
        np.array([point.time_s for point in looking]),
        tuple(looking),
        tuple(scenario.species),
    )


def _later(point: Waypoint, seconds: float) -> Waypoint:
    return msgspec.structs.replace(point, time_s=point.time_s + seconds)


def _toward(
    course: Course, gaze: Waypoint, state: State, place: Array, t: float
) -> tuple[float, float]:
    """Heading and pitch (rad) of a waypoint's gaze target; the present ones if it is gone."""
    if gaze.look_at_cm:
        way = np.array(gaze.look_at_cm) - place
    elif gaze.follow:
        fishes, species = state.fishes, course.species.index(gaze.follow)
        there = fishes.position[(fishes.species == species) & fishes.alive]
        way = middle_of(there, place) - place
    else:
        start = t if course.curve.loop else min(t, course.seconds - AHEAD_S)
        way = curve_at(course.curve, start + AHEAD_S)[0] - curve_at(course.curve, start)[0]
    return angles_of(way, state)


def angles_of(way: Array, state: State) -> tuple[float, float]:
    """Heading and pitch (rad) along a `way` (3,); the present ones if it is too short."""
    level = math.hypot(way[0], way[1])
    if level + abs(way[2]) < 1.0:
        heading, pitch = state.submarine.angles
        return float(heading), float(pitch)
    return math.atan2(way[1], way[0]), math.atan2(way[2], level)


def middle_of(there: Array, place: Array) -> Array:
    """The mean (3,) of places (n, 3), weighted to those near `place`; `place` if none."""
    if not len(there):
        return place
    there = there.astype(np.float64)
    weight = 1.0 / (1.0 + ((there - place) ** 2).sum(axis=1) / NEAR_CM**2) ** 2
    return np.asarray(weight @ there / weight.sum())


def _eased(share: float) -> float:
    """From 0 to 1 with a level start and end."""
    return share * share * (3.0 - 2.0 * share)


def _fault(place: Array, velocity: Array, sea: Sea, bounds: Bounds, rocks: list[str]) -> str | None:
    """The fault of a hull at `place` with this velocity as a message, or None."""
    speed = float(np.linalg.norm(velocity))
    if speed > AHEAD_CM_S:
        return f"moves at {speed:.0f} cm/s, expected at most {AHEAD_CM_S:g}"
    x, y, z = here = vector(place)
    gaps = {
        "the rim of the sea": bounds.radius_cm - math.hypot(x, y),
        "the surface": -z,
        "the seabed": z - height_at(sea.heights, sea.half_width, x, y),
        "the reef": z - height_at(sea.floor, sea.half_width, x, y),
    }
    gaps |= {f"`pillar[{k}]`": from_pillar(row, here)[1] for k, row in enumerate(sea.pillars)}
    for name, row in zip(rocks, sea.rocks, strict=True):
        gaps[name] = min(from_rock(row, here)[1], gaps.get(name, math.inf))
    nearest = min(gaps, key=lambda name: gaps[name])
    if gaps[nearest] >= HULL_CM:
        return None
    gap = math.floor(10.0 * gaps[nearest]) / 10.0  # rounded down: it is less than expected
    return f"is {gap:.1f} cm from {nearest}, expected at least {HULL_CM:g}"
