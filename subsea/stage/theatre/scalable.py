"""Warp meshes of Scalable Display's OPENMESH files, ``.ol``.

Lines of a keyword and its value: ``VERTICES`` and ``FACES`` (how many), ``NATIVEXRES`` and
``NATIVEYRES`` (pixels), ``ORTHO_LEFT`` … ``ORTHO_TOP`` (edges of the projector in shares of those),
``PERSPECTIVE_LEFT`` … ``PERSPECTIVE_TOP`` (edges of the view in degrees, left and bottom usually
negative) with ``PERSPECTIVE_YAW`` (to the left), ``PERSPECTIVE_PITCH`` (up) and
``PERSPECTIVE_ROLL`` (counterclockwise). A node is a line ``x y brightness s t``, x and y in pixels
from the lower left corner, brightness to 255, u = 1 - t and v = 1 - s; a face is ``[ a b c ]``.
No example file is public: this follows SGCT's reader (src/correction/scalable.cpp).
"""

import numpy as np

from subsea.base.errors import UserError
from subsea.stage.theatre.measured_mesh import (
    MAX_NODES,
    MAX_TRIANGLES,
    MeasuredMesh,
    ViewAngles,
    node_mesh,
    numbers_of,
    turned,
    turns,
)
from subsea.stage.theatre.numbered_lines import numbered_lines
from subsea.stage.theatre.warp import mesh, rasterized

MAX_BYTES = 64 * 2**20
MASK_SIDE = 512  # pixels of the longer side: brightness is smooth
EDGES = ("LEFT", "RIGHT", "BOTTOM", "TOP")


def parse_scalable(data: bytes, size: tuple[int, int], where: str) -> MeasuredMesh:
    """The warp, brightness and view for a projector of `size`; a UserError names `where`."""
    keys: dict[str, float] = {}
    nodes: list[list[float]] = []
    faces: list[list[float]] = []
    for number, (first, *rest) in numbered_lines(data, where):
        at = f"{where}: line {number}"
        if first == "[":
            faces.append(numbers_of(rest, 3, at, "a b c of a face"))
        elif first[0].isalpha():
            # Text such as `MAPPING NORMALIZED` is of no use here.
            if rest and _is_number(rest[0]):
                keys[first.upper()] = float(rest[0])
        else:
            nodes.append(numbers_of([first, *rest], 5, at, "x y brightness s t"))
        if len(nodes) > MAX_NODES or len(faces) > MAX_TRIANGLES:
            raise UserError(f"more than {MAX_NODES} nodes, expected fewer", file=where)
    for name, found in (("VERTICES", nodes), ("FACES", faces)):
        if keys.get(name) != len(found) or not found:
            said = keys.get(name, float("nan"))
            raise UserError(f"{name} {said:g}, but {len(found)} lines of them", file=where)
    x, y, brightness, s, t = np.array(nodes).T
    left, right, bottom, top = (
        keys.get(f"ORTHO_{edge}", default)
        for edge, default in zip(EDGES, (0.0, 1.0, 0.0, 1.0), strict=True)
    )
    across, up = keys.get("NATIVEXRES", 0.0), keys.get("NATIVEYRES", 0.0)
    spans = np.array([across, up, right - left, top - bottom])
    if not np.isfinite(spans).all() or (np.abs(spans) < 1e-9).any():
        raise UserError("NATIVEXRES, NATIVEYRES or ORTHO_… have no area", file=where)
    with np.errstate(over="ignore", invalid="ignore"):
        places = np.column_stack([(x / across - left) / spans[2], (y / up - bottom) / spans[3]])
        sources = np.column_stack([1.0 - t, 1.0 - s])
    order = np.nan_to_num(np.array(faces), nan=-1.0, posinf=-1.0, neginf=-1.0)
    triangles = np.clip(order, -1, MAX_NODES).astype(np.int64)
    warp = node_mesh(places, sources, triangles, where)
    wide, high = (max(round(MASK_SIDE * side / max(size)), 1) for side in size)
    light = np.clip(np.nan_to_num(brightness) / 255.0, 0.0, 1.0)
    mask = None
    if light.min() < 1.0:
        whole = mesh(np.nan_to_num(np.clip(places, -1, 2)), sources, triangles)
        mask = np.zeros((high, wide, 4), np.float32)
        mask[..., :3] = rasterized(whole, light, (wide, high))[..., None]
    return MeasuredMesh(warp, mask, _view(keys))


def _view(keys: dict[str, float]) -> ViewAngles | None:
    if not any(f"PERSPECTIVE_{edge}" in keys for edge in EDGES):
        return None
    yaw, pitch, roll = (keys.get(f"PERSPECTIVE_{n}", 0.0) for n in ("YAW", "PITCH", "ROLL"))
    turn = turned(turns(2, roll) @ turns(1, yaw) @ turns(0, pitch))
    left, right, bottom, top = (keys.get(f"PERSPECTIVE_{edge}", 0.0) for edge in EDGES)
    return ViewAngles(*turn, left, right, bottom, top)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
