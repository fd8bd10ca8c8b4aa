"""The camera cued by directions, with a smooth way to each of its places.

Stateless: cues are in the state of the world. A way continues from the submarine's position and
velocity, also after a rewind or after the pilot steered.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError, unknown
from subsea.directing.director import latest
from subsea.dive.camera_way import beside, clear, nearer
from subsea.dive.captions import shown_s
from subsea.dive.tour import Steer, Tour, steer_along
from subsea.geometry.rotation import matrix
from subsea.scenario.directions import Camera, Direction
from subsea.scenario.schema import AUTOPILOT, DIRECTED, Scenario
from subsea.submarine.vessel import (
    AHEAD_CM_S,
    STATION,
    Course,
    Helm,
    Rail,
    angles_of,
    board,
    course_of,
    middle_of,
    rail_at,
)
from subsea.view.rig import CameraPose
from subsea.world.world import TICK_S, World

LOOK_S = 6.0  # default time to look from a place
LEAP_CM = 30.0
ON_RAILS_CM = 0.5  # a tour nearer than this is followed exactly
SLOPES = -0.15, 0.35  # least and largest slope of a view from the side
BEHIND = 0.25  # slope of a view from behind


class CameraGoal(NamedTuple):
    """The target of a cued camera: place, velocity and direction."""

    place: Array  # (3,) cm
    velocity: Array  # (3,) cm/s
    target: Array | None  # (3,) cm, what it looks at ...
    angles: tuple[float, float] = (0.0, 0.0)  # ... or rad, heading and pitch


def is_directed(scenario: Scenario) -> bool:
    """True if a direction of the scenario cues a camera."""
    return any(one.camera is not None for one in scenario.direction)


def check_tour(scenario: Scenario, tour: str) -> None:
    """Raise a UserError unless the tour exists: autopilot, directions, or a named tour."""
    if tour == DIRECTED and not is_directed(scenario):
        raise UserError("tour 'directed': no [[direction]] of this scenario has a `camera`")
    known = [AUTOPILOT, *[DIRECTED] * is_directed(scenario), *(one.name for one in scenario.tour)]
    if tour not in known:
        raise unknown("tour", tour, known)


def tour_steering(world: World, tour: str) -> Steer:
    """Steer on a tour from its beginning; `check_tour` must have accepted it."""
    if tour == DIRECTED:
        return directed_steering(world)
    return steer_along(world, None if tour == AUTOPILOT else course_of(world.scenario, tour))


def endless_tour(world: World, name: str, since_s: float = 0.0) -> Steer:
    """Steer on a tour from now on, then by the autopilot.

    A named tour starts `since_s` after its beginning; directions continue from their state. The
    autopilot also takes over if the scenario has no tour of that name.
    """
    autopilot = Tour()
    if name == DIRECTED and is_directed(world.scenario):
        show = directed_steering(world)
        return lambda world: autopilot.steer(world) if is_over(world) else show(world)
    if name not in {tour.name for tour in world.scenario.tour}:
        return autopilot.steer
    course = course_of(world.scenario, name)
    first, start = world.state.tick - since_s / TICK_S, rail_at(course, world.state, since_s)
    board(world.state.submarine, start, start)

    def steer(world: World) -> Helm | Rail:
        t = (world.state.tick + 1 - first) * TICK_S
        over = not course.curve.loop and t > course.seconds
        return autopilot.steer(world) if over else rail_at(course, world.state, t)

    return steer


def is_over(world: World) -> bool:
    """True if a direction ended the film, or all cameras and captions were shown in full.

    Repeated ones count after they were shown once.
    """
    scenario, log = world.scenario, world.state.directions
    if any(one.end for one in scenario.direction):
        return any(one.end and log.began[k] >= 0 for k, one in enumerate(scenario.direction))
    for k, one in enumerate(scenario.direction):
        if one.camera is None and one.caption is None:
            continue
        gone_s = (world.state.tick - int(log.began[k])) * TICK_S
        repeats = one.every_s is not None or not one.once
        if log.began[k] < 0 or (gone_s < _lasts_s(scenario, one) and not repeats):
            return False
    return True


def is_cut(before: CameraPose | None, now: CameraPose, elapsed_s: float) -> bool:
    """True if the eye moved farther in `elapsed_s` than the hull can: a cut."""
    if before is None:
        return False
    return bool(np.linalg.norm(now.eye - before.eye) > LEAP_CM + 2.0 * AHEAD_CM_S * elapsed_s)


def _lasts_s(scenario: Scenario, one: Direction) -> float:
    """Time that a direction shows its camera and caption, s."""
    words_s = 0.0 if one.caption is None else shown_s(one.caption, one.for_s)
    if one.camera is None:
        return words_s
    if one.camera.tour is not None:
        return max(words_s, course_of(scenario, one.camera.tour).seconds)
    return max(words_s, one.camera.over_s + (LOOK_S if one.for_s is None else one.for_s))


def directed_steering(world: World) -> Steer:
    """Steering to the camera of the latest direction; station before the first.

    If the first is a cut, the submarine is put there at once.
    """
    tours = {one.camera.tour for one in world.scenario.direction if one.camera is not None}
    courses = {name: course_of(world.scenario, name) for name in tours if name is not None}

    def steer(world: World) -> Helm | Rail:
        cue = latest(world.scenario, world.state, "camera")
        return STATION if cue is None else _toward(world, cue, courses)

    begin = steer(world)
    if isinstance(begin, Rail) and begin.cut:
        board(world.state.submarine, begin, begin)
    return steer


def _toward(world: World, cue: int, courses: Mapping[str, Course]) -> Rail:
    """The submarine a tick later, on its way to a direction's camera."""
    camera = world.scenario.direction[cue].camera
    assert camera is not None
    since = world.state.tick - int(world.state.directions.began[cue])  # ticks, from 1
    goal = _goal(world, cue, camera, courses)
    cut = since == 1 and camera.over_s == 0.0
    if camera.tour is not None and not cut:
        gone_s = since * TICK_S  # a tick ago
        on = rail_at(courses[camera.tour], world.state, gone_s).position
        if float(np.linalg.norm(on - world.state.submarine.position)) < ON_RAILS_CM:
            return Rail(goal.place, goal.velocity, goal.angles)
    place, velocity = clear(world, goal.place), goal.velocity
    if not cut:
        place, velocity = nearer(world, goal.place, goal.velocity, camera.over_s - since * TICK_S)
    angles = goal.angles
    if goal.target is not None:
        angles = angles_of(goal.target - place, world.state)
    return Rail(place, velocity, angles, cut)


def _goal(world: World, cue: int, camera: Camera, courses: Mapping[str, Course]) -> CameraGoal:
    """The target of a direction's camera; the current pose if no fish is left to follow."""
    boat, log = world.state.submarine, world.state.directions
    if camera.tour is not None:
        gone_s = (world.state.tick + 1 - int(log.began[cue])) * TICK_S
        rail = rail_at(courses[camera.tour], world.state, gone_s)
        return CameraGoal(rail.position, rail.velocity, None, rail.angles)
    still = np.zeros(3)
    stands = None if camera.position_cm is None else np.array(camera.position_cm)
    if camera.look_at_cm is not None:
        assert stands is not None
        return CameraGoal(stands, still, np.array(camera.look_at_cm))
    fishes = world.state.fishes
    shown = log.cast[cue] if camera.follow == "cast" else world.script.cues[cue].shown
    shown = shown[shown >= 0]
    shown = shown[fishes.alive[shown]]
    if not len(shown):
        angles = float(boat.angles[0]), float(boat.angles[1])
        return CameraGoal(boat.position.copy() if stands is None else stands, still, None, angles)
    target = middle_of(fishes.position[shown], boat.position if stands is None else stands)
    if stands is not None:
        return CameraGoal(stands, still, target)
    if camera.behind:
        ahead = matrix(fishes.orientation[shown])[..., 0]
        way, slope = -ahead.sum(axis=0), BEHIND
    else:
        way = boat.position - target
        slope = float(np.clip(way[2] / max(math.hypot(way[0], way[1]), 1.0), *SLOPES))
    place = beside(world, target, way, slope, camera.distance_cm)
    velocity = fishes.velocity[shown].astype(np.float64).mean(axis=0)
    return CameraGoal(place, velocity, target)
