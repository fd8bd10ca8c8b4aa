"""Pick the thing under the pointer, with the renderer's identity map.

A place on the screen is mapped back to the canvas through the patch that shows it: directly,
through an adjustment and a warp mesh, or from the faces of a cube, as in `shaders/resolve.frag`.
If two eyes share the screen, the left one counts.
"""

from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.frame.packet import Packet
from subsea.rendering.gl.id_buffer import FISH, WATER
from subsea.rendering.renderer import Renderer
from subsea.view.camera import View
from subsea.view.display_rigs import SURROUNDS
from subsea.view.meshes import shown_size, unmoved
from subsea.view.rig import (
    CUBES,
    CameraRig,
    DisplayPatch,
    Projection,
    Rect,
    front,
    seen_part,
    sources_at,
)
from subsea.view.surround import COLUMNS, ROWS, Surround, directions, half_tangent, on_faces

NEAR_PX = 4  # search radius if no fish is under the pointer
DISPLAYS = {shape: display for display, shape in SURROUNDS.items()}


class Picked(NamedTuple):
    """The visible thing at a place."""

    kind: int  # as `render.marks.KINDS` are numbered
    number: int  # index within that kind: of a fish its number in the world
    place: Array  # (3,) cm, where the ray from the eye meets it; infinite in open water


def pick(renderer: Renderer, packet: Packet, x: float, y: float) -> Picked | None:
    """Pick in the `packet` drawn last, at shares of the screen ahead; None where it is dark."""
    at = canvas_place(renderer.rig, x, y)
    if at is None:
        return None
    number = next((k for k, view in enumerate(packet.views) if _within(view.viewport, at)), None)
    if number is None:
        return None
    view = packet.views[number]
    part = _about(view.viewport, at)
    seen = renderer.id_maps(packet, (number,), part)
    height, width = seen.kind.shape
    # Maps may be larger or smaller than the canvas.
    column = min(int((at[0] - part[0]) / part[2] * width), width - 1)
    row = height - 1 - min(int((at[1] - part[1]) / part[3] * height), height - 1)
    if seen.kind[row, column] != FISH and (seen.kind == FISH).any():
        rows, columns = np.nonzero(seen.kind == FISH)
        nearest = np.argmin((rows - row) ** 2 + (columns - column) ** 2)
        row, column = int(rows[nearest]), int(columns[nearest])
    kind = int(seen.kind[row, column])
    depth = np.inf if kind == WATER else float(seen.depth[row, column])
    return Picked(kind, int(seen.number[row, column]), _place(view, at, depth))


def canvas_place(rig: CameraRig, x: float, y: float) -> tuple[float, float] | None:
    """The canvas pixel, from the lower left, shown at a place on the screen ahead.

    None where the screen is dark. The last of overlapping patches counts.
    """
    ahead = front(rig)
    left, bottom, width, height = seen_part(ahead)
    pixel = left + x * width, bottom + (1.0 - y) * height
    patch = next(
        (
            patch
            for patch in reversed(rig.patches)
            if patch.output == ahead.output and _within(patch.place, pixel)
        ),
        ahead,
    )
    a, b, across, up = patch.place
    return _source(patch, (pixel[0] - a) / across, (pixel[1] - b) / up)


def _source(patch: DisplayPatch, x: float, y: float) -> tuple[float, float] | None:
    """The canvas pixel of the left eye at a place in shares of a patch."""
    share = unmoved(patch, (x, y))
    if patch.warp is not None:
        share = sources_at(patch.warp, share[None])[0]
    left, bottom, width, height = patch.left
    if patch.shape in CUBES:
        # A dome that a mesh bends is a square.
        square = patch.warp is not None and patch.shape == Projection.DOME
        shown = np.array([1.0, 1.0] if square else shown_size(patch))
        surround = Surround(*np.degrees(patch.wide))
        size: Any = tuple(shown)
        d = directions(DISPLAYS[patch.shape], size, surround, (share * shown)[None])
        if patch.shape == Projection.PANORAMA:  # its eye separation is on the cylinder
            d = d / np.hypot(d[:, 0], d[:, 2])[:, None]
        d[:, 0] += patch.apart
        if np.isnan(d).any():
            return None
        face, own = on_faces(d)
        inside = 0.5 + 0.5 * own[0] / half_tangent(height // ROWS)
        share = (np.array([face[0] % COLUMNS, face[0] // COLUMNS]) + inside) / (COLUMNS, ROWS)
    if np.isnan(share).any():
        return None
    return left + float(share[0]) * width, bottom + float(share[1]) * height


def _about(viewport: Rect, at: tuple[float, float]) -> Rect:
    """The pixels of a viewport near a place."""
    low = [max(int(value) - NEAR_PX, start) for value, start in zip(at, viewport[:2], strict=True)]
    high = [
        min(int(value) + NEAR_PX + 1, start + size)
        for value, start, size in zip(at, viewport[:2], viewport[2:], strict=True)
    ]
    return low[0], low[1], high[0] - low[0], high[1] - low[1]


def _place(view: View, at: tuple[float, float], depth: float) -> Array:
    """The point (3,), cm, at a pixel and a depth along the axis of the view."""
    x, y, width, height = view.viewport
    p = view.projection.astype(np.float64)
    across, up = 2.0 * (at[0] - x) / width - 1.0, 2.0 * (at[1] - y) / height - 1.0
    way = np.array([(across + p[0, 2]) / p[0, 0], (up + p[1, 2]) / p[1, 1], -1.0])
    way = way @ view.view[:3, :3].astype(np.float64)
    return np.full(3, np.inf) if np.isinf(depth) else np.asarray(view.eye) + depth * way


def _within(rect: Rect, at: tuple[float, float]) -> bool:
    return all(
        low <= value < low + size for value, low, size in zip(at, rect[:2], rect[2:], strict=True)
    )
