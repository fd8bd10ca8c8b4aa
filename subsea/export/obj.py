"""Move a user's OBJ mesh with a recorded segment: an OBJ file for each frame (KS III.A)."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.files import logical_lines, read_input, replacing, text_of
from subsea.biomechanics.body import Floats
from subsea.geometry.tetrahedra import tetrahedral_weights
from subsea.repertoire import Repertoire

MAX_BYTES = 256 * 2**20
MAX_DISTANCE = 3.0  # body lengths between the fish and a vertex


def read_mesh(path: Path) -> tuple[list[str], Floats]:
    """Read the lines and vertices (n, 3) of a Wavefront OBJ file; UserError for a faulty one."""
    lines, vertices = [], []
    for number, line in logical_lines(text_of(read_input(path, MAX_BYTES), path, foreign=True)):
        lines.append(line)
        if line.split(maxsplit=1)[:1] != ["v"]:
            continue
        try:
            x, y, z = (float(word) for word in line.split()[1:4])
        except ValueError as fault:
            raise UserError(
                f"line {number}: expected `v x y z`, found {line!r}", file=path
            ) from fault
        if not all(map(math.isfinite, (x, y, z))):
            raise UserError(f"line {number}: {line!r} is not finite", file=path)
        vertices.append((x, y, z))
    if not vertices:
        raise UserError(
            "no vertices; expected a Wavefront OBJ file with lines `v x y z`", file=path
        )
    return lines, np.array(vertices)


class BoundMesh(NamedTuple):
    """A mesh bound to the nodes."""

    lines: list[str]  # of its file
    weights: Array  # (n, 23) of the nodes, for each vertex


def fit_to_fish(vertices: Floats, repertoire: Repertoire) -> Floats:
    """Scale and move vertices (n, 3) that head along x to the length and snout of the fish."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    if high[0] <= low[0]:
        raise UserError("no extent along x, the direction of swimming")
    snout = np.array([high[0], *(low[1:] + high[1:]) / 2])
    scale = repertoire.body_length_cm / (high[0] - low[0])
    return np.asarray((vertices - snout) * scale + repertoire.rest_nodes[0])


def bind_mesh(repertoire: Repertoire, path: Path, fit: bool) -> BoundMesh:
    """Bind the mesh of a file, in body axes and cm, to the nodes of a fish.

    With `fit` it only has to head along x. UserError for a faulty file or a mesh far away.
    """
    lines, vertices = read_mesh(path)
    if fit:
        try:
            vertices = fit_to_fish(vertices, repertoire)
        except UserError as fault:
            raise UserError(f"{fault}", file=path) from fault
    away = float(np.linalg.norm(vertices, axis=1).max()) / repertoire.body_length_cm
    if away > MAX_DISTANCE:
        raise UserError(
            f"a vertex lies {away:.3g} body lengths from the fish, expected at most "
            f"{MAX_DISTANCE:g}; use --fit to move the mesh to the fish",
            file=path,
        )
    return BoundMesh(lines, tetrahedral_weights(repertoire.rest_nodes, vertices))


def write_mesh(path: Path, mesh: BoundMesh, nodes: Array) -> None:
    """Write the mesh for nodes (23, 3), without normals."""
    with replacing(path) as temporary:
        temporary.write_text(_moved(mesh.lines, mesh.weights @ nodes), encoding="utf-8")


def _moved(lines: list[str], vertices: Floats) -> str:
    """Make the text of the mesh with other vertices and without normals."""
    following = iter(vertices)
    out = []
    for line in lines:
        word, *rest = line.split() or [""]
        if word == "v":
            x, y, z = next(following)
            out.append(" ".join(["v", f"{x:.6g}", f"{y:.6g}", f"{z:.6g}", *rest[3:]]))
        elif word == "f":  # `v/vt/vn` becomes `v/vt`, `v//vn` becomes `v`
            corners = ("/".join(corner.split("/")[:2]).rstrip("/") for corner in rest)
            out.append(" ".join(["f", *corners]))
        elif word != "vn":
            out.append(line)
    return "\n".join(out) + "\n"
