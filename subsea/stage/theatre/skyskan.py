"""Warp meshes of Sky-Skan's DigitalSky, ``.skyskan``.

Lines ``Dome Azimuth=``, ``Dome Elevation=``, ``Horizontal FOV=``, ``Vertical FOV=`` (degrees) and
``U Tweak=``, ``V Tweak=``, ``Horizontal Tweak=``, ``Vertical Tweak=`` (factors; negative: none), a
line of columns and rows, and a node a line: x y u v, shares from the upper left corner; a node with
x or y of -1 is not used. No example file is public: this follows SGCT's reader
(src/correction/skyskan.cpp), which also gives the height of a view without ``Vertical FOV``.
"""

import math

import numpy as np

from subsea.base.errors import UserError
from subsea.stage.theatre.measured_mesh import (
    MeasuredMesh,
    ViewAngles,
    bounded_grid,
    grid_triangles,
    node_mesh,
    numbers_of,
)
from subsea.stage.theatre.numbered_lines import numbered_lines

MAX_BYTES = 64 * 2**20
HIGH = 1200 / 2048  # height of a view of unknown height, in shares of its width
UNUSED = -1.0


def parse_skyskan(data: bytes, where: str) -> MeasuredMesh:
    """The warp and view of a file's bytes; a UserError names `where`."""
    keys: dict[str, float] = {}
    size: tuple[int, int] | None = None
    nodes: list[list[float]] = []
    for number, words in numbered_lines(data, where):
        at = f"{where}: line {number}"
        name, equals, value = (part.strip() for part in " ".join(words).partition("="))
        if equals:
            keys[name.strip().lower()] = numbers_of([value.strip()], 1, at, f"of {name.strip()!r}")[
                0
            ]
        elif size is None:
            columns, rows = numbers_of(words, 2, at, "columns rows")
            if not (2 <= columns <= 1e6 and 2 <= rows <= 1e6):
                raise UserError(f"{at}: {columns:g}×{rows:g} nodes, expected 2×2 or more")
            size = int(columns), int(rows)
            bounded_grid(*size, where)
        else:
            nodes.append(numbers_of(words, 4, at, "x y u v"))
            if len(nodes) > size[0] * size[1]:
                raise UserError(f"{at}: more than {size[0]}×{size[1]} nodes")
    if size is None or len(nodes) != size[0] * size[1]:
        raise UserError(f"{len(nodes)} nodes, expected a line of columns and rows, and those",
                        file=where)  # fmt: skip
    x, y, u, v = np.array(nodes).T
    u_tweak, v_tweak = (keys.get(f"{axis} tweak", 1.0) for axis in "uv")
    u, v = u * (u_tweak if u_tweak > -1 else 1.0), v * (v_tweak if v_tweak > -1 else 1.0)
    unused = (x == UNUSED) | (y == UNUSED)
    places = np.column_stack([np.where(unused, np.nan, x), 1.0 - y])
    warp = node_mesh(places, np.column_stack([u, 1.0 - v]), grid_triangles(*size), where)
    return MeasuredMesh(warp, view=_view(keys, where))


def _view(keys: dict[str, float], where: str) -> ViewAngles:
    """The view; a UserError if it is incomplete."""
    names = ("dome azimuth", "dome elevation", "horizontal fov")
    if missing := [name for name in names if not math.isfinite(keys.get(name, math.nan))]:
        raise UserError(f"expected a line '{missing[0].title()}='", file=where)
    azimuth, elevation, across = (keys[name] for name in names)
    up = keys.get("vertical fov", 0.0)
    if not 0 < across < 178:
        raise UserError(f"Horizontal FOV {across:g}, expected an angle below 178", file=where)
    if not 0 < up < 178:
        up = 2 * math.degrees(math.atan(HIGH * math.tan(math.radians(across / 2))))
    for axis, tweak in (("across", "horizontal tweak"), ("up", "vertical tweak")):
        factor = keys.get(tweak, 1.0)
        if 0 < factor < 10:
            across, up = (across * factor, up) if axis == "across" else (across, up * factor)
    return ViewAngles(azimuth, elevation, 0.0, -across / 2, across / 2, -up / 2, up / 2)
