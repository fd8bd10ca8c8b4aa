"""Warp meshes of domeprojection.com, ``.csv``, beside a ``_frustum.csv`` with the view.

A line ``x;y;u;v;column;row``, then a node a line. x and y are shares of the projector, u and v of
the picture, both from the upper left corner; columns and rows are counted from 0. A mesh
``NAME_mesh.csv`` or ``NAME.csv`` has its view in ``NAME_frustum.csv``: a line of names, a line of
numbers, with ``heading`` (right positive), ``pitch`` (up), ``bank``, ``left`` and ``right``
(both positive outwards), ``bottom`` and ``top`` (both positive upwards), in degrees (SGCT:
src/correction/domeprojection.cpp; files of its repository, 19bbd93c, e143ee02).
"""

from pathlib import Path

import numpy as np

from subsea.base.errors import UserError
from subsea.stage.theatre.measured_mesh import (
    MAX_NODES,
    MeasuredMesh,
    ViewAngles,
    bounded_grid,
    grid_triangles,
    node_mesh,
    numbers_of,
)

MAX_BYTES = 64 * 2**20
MAX_FRUSTUM = 2**16  # bytes
NAMES = "x y u v column row"
_KEYS = ("heading", "pitch", "bank", "left", "right", "bottom", "top")


def parse_domeprojection(data: bytes, where: str) -> MeasuredMesh:
    """The warp of a file's bytes; a UserError names `where`."""
    nodes = []
    for number, words in _rows(data, where):
        if words[0] == "x":
            continue
        nodes.append(numbers_of(words, 6, f"{where}: line {number}", NAMES))
        if len(nodes) > MAX_NODES:
            raise UserError(f"more than {MAX_NODES} nodes, expected fewer", file=where)
    if not nodes:
        raise UserError(f"no nodes, expected lines of {NAMES.replace(' ', ';')}", file=where)
    table = np.array(nodes)
    grid = table[:, 4:]
    if not np.isfinite(table[:, 4:]).all() or grid.min() < 0 or (grid != np.floor(grid)).any():
        raise UserError("its columns and rows are not whole numbers from 0", file=where)
    columns, rows = (int(min(most, 1e9)) + 1 for most in grid.max(axis=0))
    bounded_grid(columns, rows, where)
    at = (grid[:, 1] * columns + grid[:, 0]).astype(np.int64)
    placed = np.full((columns * rows, 4), np.nan)  # a node that is not listed stays dark
    placed[at] = table[:, :4]
    places = np.column_stack([placed[:, 0], 1.0 - placed[:, 1]])
    sources = np.column_stack([placed[:, 2], 1.0 - placed[:, 3]])
    return MeasuredMesh(node_mesh(places, sources, grid_triangles(columns, rows), where))


def frustum_file(path: Path) -> Path:
    """The file with the view of a mesh."""
    return path.with_name(f"{path.stem.removesuffix('_mesh')}_frustum.csv")


def parse_frustum(data: bytes, where: str) -> ViewAngles:
    """The view in a ``_frustum.csv``; a UserError names `where`."""
    rows = list(_rows(data, where))[:2]
    if len(rows) < 2 or len(rows[1][1]) < len(rows[0][1]):
        raise UserError("expected a line of names and a line of numbers", file=where)
    found = dict(zip(rows[0][1], rows[1][1], strict=False))
    words = [found.get(key, "") for key in _KEYS]
    values = numbers_of(words, len(_KEYS), f"{where}: line {rows[1][0]}", " ".join(_KEYS))
    heading, pitch, bank, left, right, bottom, top = values
    return ViewAngles(heading, pitch, bank, -left, right, bottom, top)


def _rows(data: bytes, where: str) -> list[tuple[int, list[str]]]:
    """Number and cells of each line that is not empty."""
    try:
        lines = data.decode("utf-8-sig").split("\n")
    except UnicodeDecodeError as fault:
        raise UserError("not text, expected cells between semicolons", file=where) from fault
    return [
        (number, [cell.strip() for cell in line.split(";")])
        for number, line in enumerate(lines, 1)
        if line.strip()
    ]
