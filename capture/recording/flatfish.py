"""Record a flatfish: simulated upright, recorded lying, so that it undulates up and down.

Muscles and water move it straight ahead. They cannot turn it to the side, as its body bends in a
vertical plane. So its turns follow a path, as those of a ray without muscles: every part of the
body turns where the path does, at the speed of the straight swim. The nodes of the body frame stay
on the path, so that the beat does not pitch the frame.
"""

import math
from typing import Any

import numpy as np

from capture.recording.record import Recorded, motion_of
from capture.recording.record import assemble as assemble_upright
from capture.recording.spine_motion import FRAME_NODES, SwimPath
from subsea.base.arrays import Array
from subsea.biomechanics.body import Floats, build_body
from subsea.biomechanics.controllers import LEFT
from subsea.biomechanics.trial import displacement
from subsea.fish.forms import couple_surface, lay_nodes
from subsea.fish.skinning import place
from subsea.fish.species import Species
from subsea.repertoire import SEGMENTS, Repertoire
from subsea.repertoire.schema import ACYCLIC, BASIC_SEGMENTS
from subsea.repertoire.segments import make_segment, run_trial, side_of

SOURCE = "flatfish"
GRADUAL_DEG = 12.0  # of heading in a beat of a gradual turn
COAST_DEG = 2.0  # the same of the four ticks of a coast
SHARP_DEG = 90.0
SHARP_WAY = 1.6  # body lengths of the path of a sharp turn: a mean radius of one length
STRAIGHT = {  # the straight motion of each turn
    "gradual": "swim_medium", "sharp": "swim_medium", "coast": "swim_coast",
}  # fmt: skip
BESIDE = 1.5  # body lengths of path before its start and behind its end
PATH_STEPS = 4000


def segments_of(species: Species) -> tuple[str, ...]:
    """The segments of a flatfish: it makes no escapes, no turns from rest, and does not row."""
    names = {*BASIC_SEGMENTS, "swim_start", "swim_stop", "swim_coast"}
    names |= {"turn_left_coast", "turn_right_coast"}
    if "burst" in motion_of(species).swim.grades:
        names.add("swim_burst")
    return tuple(name for name in SEGMENTS if name in names)


def record_segment(species: Species, name: str) -> Recorded:
    """Record one segment, with control points."""
    motion, length = motion_of(species), species.length_cm
    kind, _, grade = name.rpartition("_")
    trial = run_trial(motion, name if kind == "swim" else STRAIGHT[grade])
    frames = _ahead(trial.frames)
    beats, turn = 1, 0.0
    if kind != "swim":
        side = 1.0 if side_of(name) == LEFT else -1.0
        degrees = {"gradual": GRADUAL_DEG, "sharp": SHARP_DEG, "coast": COAST_DEG}[grade]
        turn = side * math.radians(degrees)
    if grade == "sharp":
        stride = float(displacement(frames)[0]) / length
        beats = math.ceil((1.0 + SHARP_WAY) / stride)
        frames = _repeated(frames, beats)
    body = build_body(motion.body)
    way = frames @ np.array([1.0, 0.0, 0.0]) @ body.mass / body.mass.sum()  # of the middle
    way = (way - way[0]) / length
    if grade not in ACYCLIC or grade == "sharp":
        way = np.linspace(0.0, way[-1], len(way))  # without the surge of the beat
    centre = motion.body.stations[2] / length
    bend = (0.0, way[-1]) if grade != "sharp" else (centre, way[-1] - (1.0 - centre))
    path = SwimPath(float(way[-1]), bend, turn, grade != "sharp")
    lying, rest = lay_nodes(frames), lay_nodes(body.rest)
    skin = place(couple_surface("flatfish", species.surface, length, rest), lying)
    nodes, points = (_follow(part, path, length) for part in (lying, skin))
    nodes[:, FRAME_NODES] = _on_path(rest[FRAME_NODES], path, way, length)
    segment = make_segment(
        nodes, length,
        pattern="left" if "left" in name else "right" if "right" in name else "forward",
        grade=grade, cyclic=grade not in ACYCLIC, surface=points, slowing=trial.slowing,
    )  # fmt: skip
    return Recorded(segment, trial.warm_up_beats)


def assemble(name: str, species: Species, recorded: dict[str, Recorded]) -> Repertoire:
    """Make a repertoire of recorded segments; its nodes at rest lie."""
    upright = assemble_upright(name, species, recorded)
    fields: dict[str, Any] = {key: getattr(upright, key) for key in upright.__dataclass_fields__}
    return Repertoire(**fields | {"source": SOURCE, "rest_nodes": lay_nodes(upright.rest_nodes)})


def _ahead(frames: Floats) -> Floats:
    """The frames (T + 1, 23, 3) of a fish that swims along the x axis.

    At the start the middle of the second ring, the origin of the body frame, has x = 0.
    """
    way = displacement(frames)
    angle = np.arctan2(-way[2], way[0])
    c, s = np.cos(angle), np.sin(angle)
    turned = frames @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return np.asarray(turned - (turned[0, 5:9, 0].mean(), 0.0, turned[..., 2].mean()))


def _repeated(frames: Floats, beats: int) -> Floats:
    """A beat that is repeated, and goes on from where it ends."""
    step = displacement(frames)
    parts = [frames[:1], *(frames[1:] + beat * step for beat in range(beats))]
    return np.concatenate(parts)


def _places(path: SwimPath) -> tuple[Array, Array, Array]:
    """Distances (k,) along a path from its start, and the points ahead and to the right there."""
    at = np.linspace(-BESIDE, path.length + BESIDE, PATH_STEPS)
    heading = path.heading(0.5 * (at[1:] + at[:-1]))
    step = np.diff(at)
    ahead, right = (
        np.concatenate([[0.0], np.cumsum(step * part)])
        for part in (np.cos(heading), -np.sin(heading))
    )
    return at, ahead - np.interp(0.0, at, ahead), right - np.interp(0.0, at, right)


def _follow(points: Array, path: SwimPath, length: float) -> Floats:
    """Bend points (T, n, 3) about a straight line so that this becomes the path, cm."""
    along = points[..., 0] / length
    at, ahead, right = _places(path)
    heading = path.heading(along)
    out = np.array(points, np.float64)
    out[..., 0] = length * np.interp(along, at, ahead) + points[..., 2] * np.sin(heading)
    out[..., 2] = length * np.interp(along, at, right) + points[..., 2] * np.cos(heading)
    return out


def _on_path(nodes: Array, path: SwimPath, way: Array, length: float) -> Array:
    """Nodes (n, 3) of a stiff body (T, n, 3) whose middle is at ``way`` (T,) on the path."""
    at, ahead, right = _places(path)
    heading = path.heading(way)[:, None]
    c, s = np.cos(heading), np.sin(heading)
    x, y, z = nodes.T
    return np.stack(
        [
            length * np.interp(way, at, ahead)[:, None] + c * x + s * z,
            np.broadcast_to(y, (len(way), len(y))),
            length * np.interp(way, at, right)[:, None] - s * x + c * z,
        ],
        axis=-1,
    )
