"""Reading and writing repertoire files (`repertoires/SPECIES.h5`)."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from subsea.base import hdf5
from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.repertoire.schema import (
    BASIC_SEGMENTS,
    CONTROL_POINTS,
    FORMAT,
    GRADES,
    MAX_FRAMES,
    MAX_GLIDE_FRAMES,
    NODES,
    PATTERNS,
    VERSION,
    Repertoire,
    Segment,
    Transitions,
)
from subsea.repertoire.transitions import plan_transitions

READABLE = range(2, VERSION + 1)  # version 2 has the basic segments only
UNIT_TOLERANCE = 1e-4  # of a recorded quaternion's length
MAX_EXTENT_BL = 3.0  # limit for distances of nodes and control points from the centre


def read_repertoire(path: Path) -> Repertoire:
    """Read and check a repertoire; UserError with file and key for a fault."""
    where = str(path)
    with hdf5.reading(path) as file:
        if "format" not in file.attrs:
            raise UserError(f"not a repertoire, expected attribute format = {FORMAT!r}", file=where)
        version = hdf5.attribute(file, "version", int, where)
        if version not in READABLE:
            remedy = "update subsea or record it again" if version > VERSION else "record it again"
            raise UserError(
                f"version {version}, this program reads versions {READABLE[0]} to {VERSION}; "
                f"{remedy} (subsea-capture record)",
                file=where,
            )
        if hdf5.attribute(file, "format", str, where) != FORMAT:
            raise UserError(f"not a repertoire, expected attribute format = {FORMAT!r}", file=where)
        length = _positive(file, "body_length_cm", where)
        rest = hdf5.array(hdf5.subgroup(file, "rest", where), "nodes", (NODES, 3), where + "/rest")
        group = hdf5.subgroup(file, "segments", where)
        segments = {
            name: _read_segment(
                hdf5.subgroup(group, name, f"{where}/segments"),
                length,
                f"{where}/segments/{name}",
            )
            for name in sorted(group)
        }
        if not segments:
            raise UserError("empty, expected at least one segment", file=f"{where}/segments")
        repertoire = Repertoire(
            species=hdf5.attribute(file, "species", str, where),
            tick_s=_positive(file, "tick_s", where),
            body_length_cm=length,
            source=hdf5.attribute(file, "source", str, where),
            provenance=_provenance(file, where),
            rest_nodes=rest,
            segments=segments,
        )
        return replace(repertoire, transitions=_read_transitions(file, repertoire, where))


def write_repertoire(path: Path, repertoire: Repertoire) -> None:
    """Write a repertoire atomically, with the same bytes for the same contents."""
    with hdf5.writing(path) as file:
        file.attrs["format"] = hdf5.text(FORMAT)
        file.attrs["version"] = VERSION
        file.attrs["species"] = hdf5.text(repertoire.species)
        file.attrs["tick_s"] = repertoire.tick_s
        file.attrs["body_length_cm"] = repertoire.body_length_cm
        file.attrs["source"] = hdf5.text(repertoire.source)
        file.attrs["provenance"] = hdf5.text(json.dumps(repertoire.provenance, sort_keys=True))
        file["rest/nodes"] = repertoire.rest_nodes
        for name in sorted(repertoire.segments):
            segment = repertoire.segments[name]
            group = file.create_group(f"segments/{name}")
            group["increment_rotation"] = segment.increment_rotation
            group["increment_translation"] = segment.increment_translation
            group["nodes"] = segment.nodes
            if segment.control_points is not None:
                group.create_dataset(
                    "control_points",
                    data=segment.control_points.astype(np.float32),
                    compression="gzip",
                    shuffle=True,
                )
            for key in ("pattern", "grade"):
                group.attrs[key] = hdf5.text(getattr(segment, key))
            for key in ("cyclic", "speed_cm_s", "turn_deg", "loop_error_bl", "bounding_radius_bl"):
                group.attrs[key] = getattr(segment, key)
            if segment.slowing:
                group.attrs["slowing"] = segment.slowing
        if all(name in repertoire.segments for name in BASIC_SEGMENTS):
            known = [repertoire.segments[name] for name in repertoire.recorded_names()]
            plan = plan_transitions(known)
            for key, values in plan._asdict().items():
                file[f"transitions/{key}"] = values.astype(np.int16)


def _read_transitions(file: Any, repertoire: Repertoire, where: str) -> Transitions | None:
    """The transitions that were planned when the file was written, or None without them."""
    segments, names = repertoire.segments, repertoire.recorded_names()
    missing = any(name not in segments for name in BASIC_SEGMENTS)
    if missing or not hdf5.has_member(file, "transitions"):
        return None
    group, where = hdf5.subgroup(file, "transitions", where), where + "/transitions"
    rows = sum(len(segments[name].nodes) for name in names)
    entry, frames, leave = (
        hdf5.array(group, key, (rows, len(names)), where, kind="i") for key in Transitions._fields
    )
    starts = np.cumsum([0, *(len(segments[name].nodes) for name in names)])
    for k, name in enumerate(names):
        last = starts[k + 1] - 1 if segments[name].cyclic else starts[k]
        if (entry[:, k] < starts[k]).any() or (entry[:, k] > last).any():
            raise UserError(
                f"leads into {name} elsewhere than where it may begin", file=f"{where}/entry"
            )
        if not leave[starts[k] : starts[k + 1]].any(axis=0).all():
            raise UserError(f"no way leads out of {name}", file=f"{where}/leave")
    if (frames < 1).any() or (frames > MAX_GLIDE_FRAMES).any():
        raise UserError(f"expected 1 to {MAX_GLIDE_FRAMES}", file=f"{where}/frames")
    leave = leave.astype(np.bool_)
    if hdf5.attribute(file, "version", int, where) == 2:
        for k, name in enumerate(names):
            if not segments[name].cyclic:  # it had to be played to its end
                leave[starts[k] : starts[k + 1] - 1] = False
    return Transitions(entry, frames, leave)


def _read_segment(group: Any, length: float, where: str) -> Segment:
    rotation = hdf5.array(group, "increment_rotation", (None, 4), where)
    frames = len(rotation)
    if not 2 <= frames <= MAX_FRAMES:
        raise UserError(f"{frames} frames, expected 2 to {MAX_FRAMES}", file=where)
    if np.abs(np.linalg.norm(rotation, axis=1) - 1.0).max() > UNIT_TOLERANCE:
        raise UserError(
            "expected unit quaternions (w, x, y, z)", file=f"{where}/increment_rotation"
        )
    translation = hdf5.array(group, "increment_translation", (frames, 3), where)
    nodes = hdf5.array(group, "nodes", (frames, NODES, 3), where)
    points = None
    if hdf5.has_member(group, "control_points"):
        points = hdf5.array(group, "control_points", (frames, CONTROL_POINTS, 3), where)
    slowing: float = 0.0
    if "slowing" in group.attrs:
        slowing = hdf5.attribute(group, "slowing", float, where)
        if not 0.0 <= slowing < 1.0:
            raise UserError(f"slowing is {slowing:g}, expected 0 to 1", file=where)
    for name, values in (("increment_translation", translation), ("nodes", nodes)):
        _within(values, length, f"{where}/{name}")
    if points is not None:
        _within(points, length, f"{where}/control_points")
    return Segment(
        pattern=_choice(group, "pattern", PATTERNS, where),
        grade=_choice(group, "grade", GRADES, where),
        cyclic=hdf5.attribute(group, "cyclic", bool, where),
        increment_rotation=rotation,
        increment_translation=translation,
        nodes=nodes,
        control_points=points,
        speed_cm_s=_positive(group, "speed_cm_s", where),
        turn_deg=hdf5.attribute(group, "turn_deg", float, where),
        loop_error_bl=hdf5.attribute(group, "loop_error_bl", float, where),
        bounding_radius_bl=_positive(group, "bounding_radius_bl", where),
        slowing=slowing,
    )


def _within(values: Array, length: float, where: str) -> None:
    if np.abs(values).max() > MAX_EXTENT_BL * length:
        raise UserError(f"reaches beyond {MAX_EXTENT_BL:g} body lengths", file=where)


def _positive(group: Any, name: str, where: str) -> float:
    value: float = hdf5.attribute(group, name, float, where)
    if value <= 0.0:
        raise UserError(f"attribute {name!r} is {value:g}, expected a positive number", file=where)
    return value


def _choice(group: Any, name: str, choices: tuple[str, ...], where: str) -> str:
    value: str = hdf5.attribute(group, name, str, where)
    if value not in choices:
        raise UserError(f"{name} is {value!r}, expected one of {', '.join(choices)}", file=where)
    return value


def _provenance(file: Any, where: str) -> dict[str, Any]:
    text = hdf5.attribute(file, "provenance", str, where)
    try:
        value = json.loads(text)
    except (ValueError, RecursionError) as fault:
        raise UserError("attribute 'provenance' is not JSON", file=where) from fault
    if not isinstance(value, dict):
        raise UserError("attribute 'provenance' is not a JSON object", file=where)
    return value
