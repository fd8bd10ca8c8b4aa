"""The atlas: one texture with the skin sheets of all species, each region in a gutter of its own.

Gutters repeat the border of a region, so that no mipmap blends it with its neighbours on the sheet.
"""

from math import ceil, sqrt
from typing import Any

import numpy as np

from subsea.base.arrays import Array, Bytes
from subsea.fish.sheet_layout import (
    BODY,
    DORSAL,
    PECTORAL,
    PELVIC,
    SIZE,
    VENTRAL,
    SheetRegion,
    crop,
)
from subsea.rendering.gl.textures import mipmapped

COARSEST = 5  # last mipmap of the atlas, used by specks
GUTTER = 2**COARSEST  # texels around a region: one texel at the coarsest mipmap
# The regions of a skin, in rows from the bottom; and as the shaders number them.
ROWS = (BODY,), (DORSAL,), (VENTRAL, PECTORAL, PELVIC)
FRAMES = DORSAL, VENTRAL, PECTORAL, PELVIC, BODY


def _texels(region: SheetRegion) -> tuple[int, int]:
    """Width and height of a region without its gutter."""
    width, height = SIZE
    return (
        round((region.right - region.left) * width),
        round((region.top - region.bottom) * height),
    )


def _corners() -> dict[SheetRegion, tuple[int, int]]:
    """Left and bottom texel of each region in a cell."""
    corners, bottom = {}, GUTTER
    for row in ROWS:
        left = GUTTER
        for region in row:
            corners[region] = left, bottom
            left += _texels(region)[0] + 2 * GUTTER
        bottom += _texels(row[0])[1] + 2 * GUTTER
    return corners


CORNERS = _corners()
CELL = (  # texels across and up of a skin with its gutters
    max(left + _texels(region)[0] for region, (left, _) in CORNERS.items()) + GUTTER,
    max(bottom + _texels(region)[1] for region, (_, bottom) in CORNERS.items()) + GUTTER,
)


def make_atlas(context: Any, skins: list[Bytes]) -> Any:
    """Make the atlas of skins, a mipmapped sRGB texture."""
    return mipmapped(context, side_by_side(skins), COARSEST, srgb=True)


def side_by_side(skins: list[Bytes]) -> Bytes:
    """Lay skins (640, 1024, 4) out on the picture of the atlas."""
    columns = _columns(len(skins))
    picture = np.zeros((ceil(len(skins) / columns) * CELL[1], columns * CELL[0], 4), np.uint8)
    around = (GUTTER, GUTTER)
    for k, skin in enumerate(skins):
        row, column = divmod(k, columns)
        for region, (left, bottom) in CORNERS.items():
            part = crop(np.moveaxis(skin, 2, 0), region)
            part = np.pad(np.moveaxis(part, 0, 2), (around, around, (0, 0)), "edge")
            place = picture[row * CELL[1] + bottom - GUTTER :, column * CELL[0] + left - GUTTER :]
            place[: part.shape[0], : part.shape[1]] = part
    return picture


def cell(kind: int, kinds: int) -> tuple[float, float, float, float]:
    """Left, bottom, width and height of a species' cell, as shares of the atlas."""
    columns, rows = _columns(kinds), ceil(kinds / _columns(kinds))
    row, column = divmod(kind, columns)
    return column / columns, row / rows, 1.0 / columns, 1.0 / rows


def _columns(kinds: int) -> int:
    """Cells in a row of the atlas, which is about square."""
    return ceil(sqrt(kinds * CELL[1] / CELL[0]))


def frame(region: SheetRegion) -> tuple[float, float, float, float]:
    """Left, bottom, width and height of a region, as shares of a cell."""
    (left, bottom), (width, height) = CORNERS[region], _texels(region)
    return left / CELL[0], bottom / CELL[1], width / CELL[0], height / CELL[1]


def on_sheet(shares: Array) -> Array:
    """The places on a skin sheet, shares of its sides, of shares of a cell (n, 2).

    Places in a gutter lie on the border of its region.
    """
    places = np.full(shares.shape, np.nan)
    around = np.array([GUTTER / CELL[0], GUTTER / CELL[1]])
    for region in FRAMES:
        corner, size = np.split(np.array(frame(region)), 2)
        mine = ((shares >= corner - around) & (shares <= corner + size + around)).all(axis=1)
        within = np.clip((shares[mine] - corner) / size, 0.0, 1.0)
        low, high = np.array(region[:2]), np.array(region[2:])
        places[mine] = low + within * (high - low)
    return places


def inside(region: SheetRegion, within: Array) -> Array:
    """Shares of a cell (n, 2) of places in a region, 0 to 1 both ways.

    Places are kept half a texel of the coarsest mipmap from the border.
    """
    left, bottom, width, height = frame(region)
    half = 0.5 * GUTTER / np.array(_texels(region))
    return np.asarray((left, bottom) + np.clip(within, half, 1.0 - half) * (width, height))
