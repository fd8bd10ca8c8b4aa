"""Warp files of SimCAD's geometry correction, ``.simcad``.

XML: ``GeometryFile/GeometryDefinition`` with ``X-FlatParameters`` and ``Y-FlatParameters``. Each
has a ``range`` in pixels and the offsets of a square grid of nodes, 33×33, row after row from the
upper left corner, to the right and down (SGCT: src/correction/simcad.cpp; its repository,
19bbd93c, has a dome of six projectors, and the same warps as SGC and CSV).
"""

import math

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.stage.theatre.archives import parse_xml
from subsea.stage.theatre.measured_mesh import (
    MeasuredMesh,
    bounded_grid,
    grid_triangles,
    node_mesh,
    numbers_of,
)

MAX_BYTES = 8 * 2**20


def parse_simcad(data: bytes, where: str) -> MeasuredMesh:
    """The warp of a file's bytes; a UserError names `where`."""
    root = parse_xml(data, where)
    definition = root.find("geometrydefinition")
    if root.tag != "geometryfile" or definition is None:
        raise UserError("expected 'GeometryFile' with a 'GeometryDefinition'", file=where)
    offsets = []
    for axis in "XY":
        name = f"{axis}-FlatParameters"
        element = definition.find(name.lower())
        if element is None:
            raise UserError(f"{name!r} is missing", file=where)
        (extent,) = numbers_of([element.get("range", "")], 1, where, f"'range' of {name}")
        if not (math.isfinite(extent) and extent > 0):
            raise UserError(f"{name}: range {extent:g}, expected a number above 0", file=where)
        words = (element.text or "").split()
        offsets.append(np.array(numbers_of(words, len(words), where, f"of {name}")) / extent)
    side = math.isqrt(len(offsets[0]))
    if side * side != len(offsets[0]) or len(offsets[0]) != len(offsets[1]):
        counts = f"{len(offsets[0])} and {len(offsets[1])}"
        raise UserError(f"{counts} offsets, expected twice the same square number", file=where)
    bounded_grid(side, side, where)
    right, down = (np.asarray(one) for one in offsets)
    sources = regular_sources(side, side)
    places = sources + np.column_stack([right, -down])
    return MeasuredMesh(node_mesh(places, sources, grid_triangles(side, side), where))


def regular_sources(columns: int, rows: int) -> Array:
    """Nodes (n, 2) of a regular grid from edge to edge, row after row from the upper left."""
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(1, 0, rows))
    return np.column_stack([u.ravel(), v.ravel()])
