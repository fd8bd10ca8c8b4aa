"""Warp meshes in the text format of Paul Bourke, as domes with a spherical mirror use.

The first line is 1 for a polar or 2 for a rectangular mesh, the second its columns and rows; then
comes a node a line: x y u v and a brightness (paulbourke.net/dataformats/meshwarp). y runs from -1
to 1 and x from -a to a, a the aspect ratio of the projector; u and v from 0 to 1; both from the
lower left. A node of negative brightness is not used. The columns of a polar mesh close to a ring.
"""

import numpy as np
from numpy.typing import NDArray

from subsea.base.errors import UserError
from subsea.stage.theatre.numbered_lines import numbered_lines
from subsea.stage.theatre.warp import mesh, rasterized, validated
from subsea.view.rig import Warp

POLAR, RECTANGULAR = 1, 2
MASK_SIDE = 512  # pixels of the longer side: brightness is smooth


def parse_bourke(
    data: bytes, size: tuple[int, int], where: str
) -> tuple[Warp, NDArray[np.float32]]:
    """The warp and the brightness for a projector of `size` pixels, from a file's bytes.

    Brightness is a mask (height, width, 4), upper row first: factors on red, green and blue code
    values, and zero. A UserError names `where`.
    """
    lines = list(numbered_lines(data, where))
    try:
        (kind,), (columns, rows) = ([int(word) for word in words] for _, words in lines[:2])
        if kind not in (POLAR, RECTANGULAR) or min(columns, rows) < 2:
            raise ValueError
    except ValueError as fault:
        raise UserError(
            "expected a line '1' or '2' and a line of columns and rows", file=where
        ) from fault
    if len(lines) - 2 != columns * rows:
        raise UserError(f"expected {columns} times {rows} nodes, got {len(lines) - 2}", file=where)
    nodes = np.empty((columns * rows, 5))
    for k, (number, words) in enumerate(lines[2:]):
        try:
            if len(words) != 5:  # numpy would broadcast a single one
                raise ValueError
            nodes[k] = [float(word) for word in words]
        except ValueError as fault:
            raise UserError(
                f"line {number}: expected x y u v and brightness", file=where
            ) from fault
    x, y, u, v, brightness = nodes.T
    aspect = size[0] / size[1]
    places = np.stack([(x / aspect + 1) / 2, (y + 1) / 2], axis=1)
    used = brightness >= 0
    left, top = (one.ravel() for one in np.meshgrid(np.arange(columns), np.arange(rows - 1)))
    right = (left + 1) % columns
    if kind == RECTANGULAR:
        left, right, top = left[right > 0], right[right > 0], top[right > 0]
    a, b = top * columns + left, (top + 1) * columns + left
    c, d = (top + 1) * columns + right, top * columns + right
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    triangles = triangles[used[triangles].all(axis=1)]
    whole_mesh = mesh(places, np.stack([u, v], axis=1), triangles)
    warp = validated(whole_mesh, where)
    wide, high = (max(round(MASK_SIDE * side / max(size)), 1) for side in size)
    mask = np.zeros((high, wide, 4), np.float32)
    mask[..., :3] = rasterized(whole_mesh, np.clip(brightness, 0.0, 1.0), (wide, high))[..., None]
    return warp, mask
