"""Close a recorded scene to a loop: the fishes swim back to where it began.

After the last frame the dive goes on, and every fish is steered onto its lead-in: the way on which
it came to its first frame. The time before the dive mirrors what followed. In the last
seconds each fish eases from its own way to the lead-in, in place, attitude and pose. It is turned
with the way that results, so it slips no more than in the dive. The last frame is the first one.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.behavior.teleop import ASIDE_RAD, STEEP_RAD, TeleopCommands
from subsea.export.conventions import continuous
from subsea.export.scene import SceneCamera
from subsea.export.take import POSES, Take
from subsea.fish.raster import smoothstep
from subsea.frame.packet import (
    FINS,
    FISH,
    INSTANCE_COLUMNS,
    ORIENTATION,
    POSITION,
    ROW_A,
    ROW_B,
    WEIGHT,
)
from subsea.geometry.rotation import from_matrix, matrix
from subsea.world.world import TICK_S, World

SHORTEST_S = 1.0  # of a scene that can be closed
GATE_S = 6.0  # of the lead-in, from its gate to the first frame
AHEAD_S = 0.7  # on the lead-in a fish aims at its place that much later
EASE_S = 5.5  # in which a fish eases to its lead-in ...
POSE_S = 0.8  # ... and its pose to that of the first frame
SLOWEST, FASTEST = 0.08, 0.95  # commanded speeds, shares of the fish's fastest
BRISK = 0.7  # on the way home
EARLY = 0.92  # share of the time to the gate in which a fish plans to come there
WIDE = 0.6  # share of the distance to the gate: a fish aims that far before it, to meet its course
DETOUR = 1.6  # length of the way home over the distance
LEAST_S, MOST_S = 12.0, 32.0  # of the way home
TURN_S = 4.0  # for turning round
COURSE_S = 0.6  # before and after a moment, over which its course is the mean
TURN_ROUND_S = 1.0  # before and after a moment, over which the ease turns a fish round
CAMERA_S = 2.0  # in which the camera turns round
STILL_CM_S = (
    1.0,
    4.0,
)  # speeds below which a fish is not turned with its way, and beyond which it is


class FishCourse(NamedTuple):
    """The way of a fish at S moments without its beats, and how the fish deviates from it."""

    place: Array  # (S, 3) cm
    angles: Array  # (S, 3) heading, pitch and roll
    aside: Array  # (S, 3) cm, from the place to the fish, in the axes of these angles
    askew: Array  # (S, 4) from these axes to those of the fish


class Lead(NamedTuple):
    """Values at moments, some of them before a film; a mirror continues them farther back."""

    values: Array  # (T, ...)
    times: Array  # (T,) seconds from the first frame of the film, rising from 0 or less

    def before(self, seconds: float) -> Array:
        """Return the values at a number of seconds before the film."""
        return self.at(-seconds)

    def at(self, t: float) -> Array:
        """Return the values at a moment; beyond the last one they go on as they did."""
        first = float(self.times[0])
        if t < first:
            return np.asarray(2.0 * self.values[0] - self.at(2.0 * first - t))
        k = int(np.clip(np.searchsorted(self.times, t) - 1, 0, len(self.times) - 2))
        share = (t - self.times[k]) / (self.times[k + 1] - self.times[k])
        return np.asarray(self.values[k] + share * (self.values[k + 1] - self.values[k]))


def run_up(start_s: float, rate: float) -> list[float]:
    """Choose the instants before a film from which its lead-in is recorded."""
    count = int(min(start_s, GATE_S) * rate)
    return [start_s - k / rate for k in range(count, 0, -1)]


def lead_in(early: Sequence[Take], film: Sequence[Take], number: int, rate: float) -> Lead:
    """Make the lead-in of the places (N, 3) of N fishes, NaN for those that come or go."""
    places = _rows([*early, *film], number)[:, :, POSITION].astype(np.float64)
    places[:, ~np.isfinite(places).all(axis=(0, 2))] = np.nan
    return Lead(places, np.arange(-len(early), len(film)) / rate)


def home_seconds(world: World, lead: Lead) -> float:
    """Estimate how long the fishes need to where their film begins, seconds."""
    fishes = world.state.fishes
    there = np.isfinite(lead.values[0, :, 0]) & fishes.alive
    if not there.any():
        return LEAST_S
    away = np.linalg.norm(lead.before(GATE_S) - fishes.position, axis=1)[there]
    needed = GATE_S + TURN_S + DETOUR * away / (BRISK * fishes.fast[there])
    return float(np.clip(needed.max(), LEAST_S, MOST_S))


def homing(lead: Lead, arrival_s: float) -> Callable[[World], TeleopCommands]:
    """Make the pilot of all fishes of a lead-in, which arrive at the instant `arrival_s`."""
    known = np.isfinite(lead.values[0, :, 0])

    def steer(world: World) -> TeleopCommands:
        fishes = world.state.fishes
        who = np.flatnonzero(known & fishes.alive)
        left = max(arrival_s - world.state.tick * TICK_S, 0.0)
        place = fishes.position[who].astype(np.float64)
        if left > GATE_S:
            gate, later = lead.before(GATE_S)[who], lead.before(GATE_S - 0.3)[who]
            far = np.linalg.norm(gate - place, axis=1)
            aim = gate - WIDE * far[:, None] * _unit(later - gate)
            length = 0.5 * (np.linalg.norm(aim - place, axis=1) + (1.0 + WIDE) * far)
            usual = np.linalg.norm(later - gate, axis=1) / 0.3
            # An early fish dawdles at first, so that all come to the gate at their usual speed.
            late = length / np.maximum(usual * EARLY * (left - GATE_S), 1.0)
            speed = usual * late * np.minimum(late, 1.0)
        else:
            aim = lead.before(left - AHEAD_S)[who]
            onward = _unit(lead.before(left - AHEAD_S - 0.1)[who] - aim)
            ahead = ((aim - place) * onward).sum(axis=1) < 0.0
            speed = np.where(ahead, 0.0, np.linalg.norm(aim - place, axis=1) / AHEAD_S)
            aim = np.where(ahead[:, None], place + onward, aim)  # it waits, and does not turn
        goal = _unit(aim - place)
        nose = matrix(fishes.orientation[who])[:, :, 0]
        turn = np.arctan2(goal[:, 1], goal[:, 0]) - np.arctan2(nose[:, 1], nose[:, 0])
        turn = (turn + np.pi) % (2.0 * np.pi) - np.pi
        return TeleopCommands(
            fish=who,
            turn=np.clip(turn / ASIDE_RAD, -1.0, 1.0),
            rise=np.clip(np.arcsin(goal[:, 2]) / STEEP_RAD, -1.0, 1.0),
            speed=np.clip(speed / fishes.fast[who], SLOWEST, FASTEST),
            feeds=np.zeros(len(who), np.bool_),
        )

    return steer


def close(
    early: Sequence[Take], film: Sequence[Take], home: Sequence[Take], rate: float, number: int,
    table: Array,
) -> tuple[list[Take], Array]:  # fmt: skip
    """Join the takes of a film and of the way home; the last one becomes the film's first.

    `early` are takes of the run-up, `number` is that of all fishes N, `table` has the recorded
    poses. Return also the greatest speed (N,), cm/s, at which a fish eases to its lead-in, NaN if
    it is not there in all frames.
    """
    takes = [*early, *film, *home]
    rows = _rows(takes, number)
    begin, later = len(early), rows[len(early) + len(film) :]
    passed = np.cumsum([0, *(len(take.simulated) for take in takes)])
    for part, first in ((rows[begin : begin + len(film)], begin), (later, begin + len(film))):
        part[:, :, POSES] += passed[first] * (part[:, :, POSES] >= len(table))
    poses = np.concatenate([table, *(take.simulated for take in takes)])
    times = np.arange(-begin, len(film)) / rate
    back = np.arange(len(home) - 1, -1, -1) / rate  # seconds to the first frame
    late = _pose_share(back)
    speed, blends = np.full(number, np.nan), [np.zeros((0, *table.shape[1:]), np.float32)]
    for i in np.flatnonzero(np.isfinite(rows[:, :, 0]).all(axis=0)).tolist():
        known = rows[: begin + len(film), i].astype(np.float64)
        own, speed[i] = _eased(later[:, i].astype(np.float64), known, times, back)
        fins = Lead(known[:, FINS], times)
        for k in np.flatnonzero(late > 0.0).tolist():
            own[k, FINS] += late[k] * (fins.before(back[k]) - own[k, FINS])
            shape, lead = _pose(own[k], poses), _pose_before(known, begin, len(home) - 1 - k, poses)
            own[k, POSES], own[k, WEIGHT] = len(poses) + len(blends) - 1, 0.0
            blends.append((shape + late[k] * (lead - shape))[None].astype(np.float32))
        own[-1] = known[begin]
        later[:, i] = own
    leaves = _eased_leaves([*early, *film], home, times, back)
    joined = [
        take._replace(rows=row[np.isfinite(row[:, 0])])
        for take, row in zip(film, rows[begin : begin + len(film)], strict=True)
    ]
    # The table of poses begins with those of the run-up.
    whole = np.concatenate([take.simulated for take in takes[: begin + 1]])
    joined[0] = joined[0]._replace(simulated=whole)
    for k, (take, row, nodes) in enumerate(zip(home, later, leaves, strict=True)):
        more = np.concatenate([take.simulated, *blends]) if k == len(home) - 1 else take.simulated
        shown = row[np.isfinite(row[:, 0])]
        joined.append(take._replace(rows=shown, simulated=more, leaves=nodes, caption=""))
    return joined, speed


def _pose_before(known: Array, begin: int, frames: int, poses: Array) -> Array:
    """Return the pose of a fish some frames before the film, which begins at row `begin`."""
    at = begin - frames
    if at >= 0:
        return _pose(known[at], poses)
    mirrored = _pose(known[min(-at, len(known) - 1)], poses)
    return np.asarray(2.0 * _pose(known[0], poses) - mirrored)


def camera_home(camera: SceneCamera, steps: int, rate: float) -> SceneCamera:
    """Let the camera go back on its own way, in `steps` frames, to where it began.

    After a cut it cuts back and waits.
    """
    count = len(camera.position)
    if camera.cuts:
        still = np.zeros(steps, int)
        return camera._replace(
            position=np.concatenate([camera.position, camera.position[still]]),
            rotation=continuous(np.concatenate([camera.rotation, camera.rotation[still]])),
            cuts=(*camera.cuts, count),
        )
    # Its clock slows down from 1, runs back evenly, and comes to 1 again.
    passed, whole = np.arange(1, steps + 1) / rate, steps / rate
    turning = min(CAMERA_S, 0.25 * whole)
    length = (count - 1) / rate
    fine = np.linspace(0.0, whole, 20 * steps + 1)
    shape = smoothstep(np.minimum(fine, whole - fine), 0.0, turning)
    area = np.trapezoid(shape, fine)
    pace = 1.0 - shape * (whole + length) / area
    clock = length + np.concatenate(
        [[0.0], np.cumsum(0.5 * (pace[1:] + pace[:-1]) * np.diff(fine))]
    )
    at = np.interp(passed, fine, clock)
    times = np.arange(count) / rate
    places = [_beyond(camera.position, times, t) for t in at]
    turns = [_turned_beyond(camera.rotation, times, t) for t in at]
    places[-1], turns[-1] = camera.position[0], camera.rotation[0]
    return camera._replace(
        position=np.concatenate([camera.position, places]),
        rotation=continuous(np.concatenate([camera.rotation, turns])),
    )


def _beyond(places: Array, times: Array, t: float) -> Array:
    """Return a place of the camera at a moment, also a little before or after its film."""
    if t > times[-1]:
        return Lead(places[::-1], times).at(times[-1] - t)
    return Lead(places, times).at(t)


def _turned_beyond(turns: Array, times: Array, t: float) -> Array:
    """Return an attitude of the camera at a moment, likewise."""
    last = float(times[-1])
    inside = -t if t < 0.0 else 2.0 * last - t if t > last else t
    turn = Lead(turns, times).at(float(np.clip(inside, 0.0, last)))
    turn = turn / np.linalg.norm(turn)
    if 0.0 <= t <= last:
        return np.asarray(turn)
    return mirrored_turn(turns[0] if t < 0.0 else turns[-1], turn)


def mirrored_turn(middle: Array, turn: Array) -> Array:
    """Mirror a rotation (..., 4) through another one: as far beyond it on the same way."""
    end = matrix(middle)
    return from_matrix(end @ np.swapaxes(matrix(turn), -1, -2) @ end)


def _rows(takes: Sequence[Take], number: int) -> Array:
    """Arrange the rows of takes by fish: (T, N, 30), NaN while a fish is not in the sea."""
    rows = np.full((len(takes), number, INSTANCE_COLUMNS), np.nan, np.float32)
    for frame, take in zip(rows, takes, strict=True):
        frame[take.rows[:, FISH].astype(int)] = take.rows
    return rows


def _eased(own: Array, known: Array, times: Array, back: Array) -> tuple[Array, float]:
    """Ease a fish (S, 30), `back` seconds before its first frame, to its lead-in.

    `known` (T, 30) is the fish at `times` of run-up and film. Return also the greatest speed of
    that, cm/s. Only courses are mixed. A recoil or a sharp turn belongs to the pose in which a fish
    makes it, so deviations from the course follow the pose: those of the lead-in come at the end.
    """
    rate = 1.0 / (back[0] - back[1])
    here = _course(own[:, POSITION], own[:, ORIENTATION], rate)
    there = _lead_course(known, times, back, rate)
    share = smoothstep(-back, -EASE_S, 0.0)[:, None]
    # A fish that would come late or beside its lead-in is moved a little all the way home.
    far = (there.place - here.place)[back <= EASE_S].mean(axis=0)
    shift = smoothstep(-back, -float(back[0]), -0.5 * EASE_S)[:, None]
    path = here.place + shift * far + share * (there.place - here.place - shift * far)
    meant = (1.0 - share) * _velocity(here.place, rate) + share * _velocity(there.place, rate)
    eased = np.linalg.norm(_velocity(path, rate) - meant, axis=1)
    axes = _axes(_eased_angles(here, there, share, path, back))
    late = _pose_share(back)[:, None]
    aside = here.aside + late * (there.aside - here.aside)
    out = own.copy()
    out[:, POSITION] = path + (axes @ aside[:, :, None])[..., 0]
    out[:, ORIENTATION] = from_matrix(axes @ matrix(_slerp(here.askew, there.askew, late)))
    return out, float(eased.max())


def _eased_angles(
    here: FishCourse, there: FishCourse, share: Array, path: Array, back: Array
) -> Array:
    """Compute the angles (S, 3) of a fish on its eased path (S, 3), so that it slips no more.

    Where the way home and the lead-in are opposite, the path turns at once, but the fish turns over
    TURN_ROUND_S before and after.
    """
    rate = 1.0 / (back[0] - back[1])
    away = np.unwrap(there.angles - here.angles, axis=0)
    middle = int(share[:, 0].searchsorted(0.5))
    away -= 2.0 * np.pi * np.round(away[middle] / (2.0 * np.pi))
    angles = here.angles + share * away
    # In the axes of its body its ways can be mixed even if they are opposite in the world.
    ahead = (1.0 - share) * _in_body(_axes(here.angles), _velocity(here.place, rate))
    ahead += share * _in_body(_axes(there.angles), _velocity(there.place, rate))
    way, meant = _velocity(path, rate), (_axes(angles) @ ahead[:, :, None])[..., 0]
    angles[:, :2] += _direction_change(meant, way)
    change = np.unwrap(angles - here.angles, axis=0)
    slowly = _smoothed(change, TURN_ROUND_S, rate)
    late = smoothstep(-back, -TURN_ROUND_S, 0.0)[:, None]
    return np.asarray(here.angles + slowly + late * (change - slowly))


def _direction_change(one: Array, other: Array) -> Array:
    """Compute changes of heading and pitch (S, 2) from ways (S, 3) to others, less if slow."""
    flat = np.minimum(*(np.hypot(way[:, 0], way[:, 1]) for way in (one, other)))
    speed = np.minimum(*(np.linalg.norm(way, axis=1) for way in (one, other)))
    heading = np.arctan2(other[:, 1], other[:, 0]) - np.arctan2(one[:, 1], one[:, 0])
    heading = (heading + np.pi) % (2.0 * np.pi) - np.pi
    pitch = np.arcsin(_unit(other)[:, 2]) - np.arcsin(_unit(one)[:, 2])
    shares = smoothstep(np.stack([flat, speed], axis=1), *STILL_CM_S)
    return np.asarray(shares * np.stack([heading, pitch], axis=1))


def _pose_share(back: Array) -> Array:
    """Return the share (S,) of the lead-in's pose, `back` seconds before the first frame."""
    return np.asarray(smoothstep(-back, -POSE_S, 0.0))


def _course(places: Array, turns: Array, rate: float) -> FishCourse:
    """Separate the course of a fish from its beats and sharp turns, with places (S, 3), cm."""
    place, angles = (_smoothed(values, COURSE_S, rate) for values in (places, _angles(turns)))
    axes = _axes(angles)
    askew = from_matrix(np.swapaxes(axes, 1, 2) @ matrix(turns))
    return FishCourse(place, angles, _in_body(axes, places - place), askew)


def _smoothed(values: Array, seconds: float, rate: float) -> Array:
    """Smooth values (S, n) over some seconds before and after each; they go on at both ends."""
    reach = max(round(seconds * rate), 1)
    weights = np.bartlett(2 * reach + 3)[1:-1]
    padded = np.pad(values, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
    columns = [np.convolve(one, weights / weights.sum(), "valid") for one in padded.T]
    return np.stack(columns, axis=1)


def _lead_course(known: Array, times: Array, back: Array, rate: float) -> FishCourse:
    """Compute the course of a lead-in `back` (S,) seconds before the first frame."""
    beyond = -np.arange(1, round(COURSE_S * rate) + 1) / rate  # some of the film shapes its end
    moments = np.concatenate([back, beyond])
    places = Lead(known[:, POSITION], times)
    turns = np.array([_turn_before(known[:, ORIENTATION], times, left) for left in moments])
    whole = _course(np.array([places.before(left) for left in moments]), turns, rate)
    return FishCourse(*(values[: len(back)] for values in whole))


def _angles(turns: Array) -> Array:
    """Compute heading, pitch and roll (S, 3) of rotations (S, 4), without jumps."""
    ahead, up, right = np.moveaxis(matrix(turns), 2, 0)
    heading, pitch = np.arctan2(ahead[:, 1], ahead[:, 0]), np.arcsin(ahead[:, 2].clip(-1.0, 1.0))
    roll = np.arctan2(-right[:, 2], up[:, 2])
    return np.unwrap(np.stack([heading, pitch, roll], axis=1), axis=0)


def _axes(angles: Array) -> Array:
    """Compute the body axes (S, 3, 3), as columns, of heading, pitch and roll (S, 3)."""
    (a, b, c), (p, q, r) = np.cos(angles.T), np.sin(angles.T)
    ahead = np.stack([b * a, b * p, q], axis=1)
    level, right = np.stack([-q * a, -q * p, b], axis=1), np.stack([p, -a, 0.0 * a], axis=1)
    c, r = c[:, None], r[:, None]
    return np.stack([ahead, c * level + r * right, c * right - r * level], axis=2)


def _turn_before(turns: Array, times: Array, seconds: float) -> Array:
    """Return the attitude of a fish some seconds before the film, as `Lead` its place."""
    mirrored = 2.0 * times[0] + seconds
    at = int(np.abs(times - max(-seconds, mirrored)).argmin())
    return turns[at] if -seconds >= times[0] else mirrored_turn(turns[0], turns[at])


def _eased_leaves(
    film: Sequence[Take], home: Sequence[Take], times: Array, back: Array
) -> list[Array | None]:
    """Ease the nodes of seaweed, where they are known, to those that lead to the first frame."""
    keys = [k for k, take in enumerate(film) if take.leaves is not None]
    lead = Lead(np.array([film[k].leaves for k in keys]), times[keys])
    share = smoothstep(-back, -EASE_S, 0.0)
    return [
        None
        if take.leaves is None
        else take.leaves + np.float32(part) * (lead.before(left) - take.leaves)
        for take, part, left in zip(home, share, back, strict=True)
    ]


def _pose(row: Array, poses: Array) -> Array:
    """Mix the two poses of an instance."""
    a, b = poses[int(row[ROW_A])], poses[int(row[ROW_B])]
    return np.asarray(a + row[WEIGHT] * (b - a))


def _slerp(one: Array, other: Array, share: Array) -> Array:
    """Mix rotations (S, 4) by shares (S, 1), at an even rate on the shorter way."""
    dot = (one * other).sum(axis=1, keepdims=True)
    other = np.where(dot < 0.0, -other, other)
    angle = np.arccos(np.clip(np.abs(dot), 0.0, 1.0 - 1e-9))
    mixed = np.sin((1.0 - share) * angle) * one + np.sin(share * angle) * other
    return np.asarray(mixed / np.linalg.norm(mixed, axis=1, keepdims=True))


def _in_body(axes: Array, ways: Array) -> Array:
    """Turn ways (S, 3) of the world into the axes (S, 3, 3) of bodies."""
    return np.asarray((ways[:, None] @ axes)[:, 0])


def _velocity(places: Array, rate: float) -> Array:
    return np.asarray(np.gradient(places, axis=0) * rate)


def _unit(ways: Array) -> Array:
    return np.asarray(ways / np.maximum(np.linalg.norm(ways, axis=-1, keepdims=True), 1e-12))
