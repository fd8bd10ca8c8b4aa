"""Keypoints of a fish: places on its skin, which move with the mouth, the tail and the body's bend.

The vertex shader that draws fishes computes them, so that they lie where they are drawn.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.fish.mesh import (
    ABSENT,
    BODY,
    PECTORAL,
    PELVIC,
    VERTEX_COLUMNS,
    root_point,
    surface_points,
)
from subsea.fish.species import Species
from subsea.fish.surface import (
    LEFT,
    RIGHT,
    PaddlePlan,
    SurfacePlan,
    U,
    V,
    rest_control_points,
)
from subsea.frame.packet import KIND, resting_instances
from subsea.geometry.curves import basis_at, dense
from subsea.rendering.fish.bodies import Skins
from subsea.rendering.fish.fishes import FishShape, ShapePoints
from subsea.view.retina import eye_place

NAMES = (
    "snout", "left_eye", "right_eye", "dorsal_front", "dorsal_rear", "anal_front", "anal_rear",
    "left_pectoral", "right_pectoral", "left_pelvic", "right_pelvic", "tail_root",
    "upper_tail_tip", "lower_tail_tip",
)  # fmt: skip
# Pairs of names that are joined in drawings, as in COCO.
SKELETON = (
    ("snout", "left_eye"), ("snout", "right_eye"), ("snout", "dorsal_front"),
    ("dorsal_front", "dorsal_rear"), ("dorsal_rear", "tail_root"), ("snout", "left_pectoral"),
    ("snout", "right_pectoral"), ("left_pectoral", "left_pelvic"),
    ("right_pectoral", "right_pelvic"), ("left_pelvic", "anal_front"),
    ("right_pelvic", "anal_front"), ("anal_front", "anal_rear"), ("anal_rear", "tail_root"),
    ("tail_root", "upper_tail_tip"), ("tail_root", "lower_tail_tip"),
)  # fmt: skip
FLIPPED = (0, 2, 1, 3, 4, 5, 6, 8, 7, 10, 9, 11, 12, 13)  # indices in a mirrored picture
SIDES = 2  # a keypoint lies midway between its places on the left and the right flank
# Among these places on the tail its upper tip is chosen, and its lower tip among the mirrored ones.
TIP_U, TIP_V = np.linspace(0.0, 0.3, 16), np.linspace(0.75, 1.0, 51)
OPAQUE = 0.75  # mean opacity of the skin around a tip
SAMPLES = 801  # along a ridge, among which the root of a fin is chosen


class _Place(NamedTuple):
    """A place on a flank: parameters from ridge to ridge, and from the snout to the tail's edge."""

    u: float
    v: float


def keypoint_shape(
    species: tuple[Species, ...], length_cm: tuple[float, ...], skins: Skins
) -> FishShape:
    """Prepare the shader for the keypoints of all species."""
    rows = [
        _vertices(one.surface, _tips(k, species, length_cm, skins)) for k, one in enumerate(species)
    ]
    vertices = np.concatenate([row for row, _ in rows]).astype(np.float32)
    # Each species has vertices of its own, and ignores those of the others.
    own = np.array([np.concatenate([one for _, one in rows])] * len(species))
    return FishShape(species, length_cm, ShapePoints(vertices, own))


def _tips(
    kind: int, species: tuple[Species, ...], length_cm: tuple[float, ...], skins: Skins
) -> list[_Place]:
    """The upper and the lower tip of a tail: the farthest places where its skin still shows."""
    plan = species[kind].surface
    rest = rest_control_points(plan, 1.0, 0.0)
    root = _ridge(rest, 0.5, plan.tail.begin)
    u, v = (one.ravel() for one in np.meshgrid(TIP_U, TIP_V, indexing="ij"))
    u, v = np.concatenate([[root.u], u, 1.0 - u]), np.concatenate([[root.v], v, v])
    vertices, own = _on_flank(rest, u, v, RIGHT)
    points = ShapePoints(vertices.astype(np.float32), np.array([own] * len(species)))
    instance = resting_instances(1)
    instance[:, KIND] = kind
    drawn = FishShape(species, length_cm, points).at(
        instance, length_cm[kind] * rest[None].astype(np.float32)
    )
    seen = skins.opacity(np.array([kind]), drawn)[0] >= OPAQUE
    away = np.linalg.norm(own[:, :2] - own[0, :2], axis=1)
    away[~seen] = -1.0
    half = len(TIP_U) * len(TIP_V)
    upper, lower = away[1 : 1 + half], away[1 + half :]
    chosen = 1 + int(upper.argmax()), 1 + half + int(lower.argmax())
    return [_Place(float(u[k]), float(v[k])) for k in chosen]


class KeypointsIn(NamedTuple):
    """Keypoints of n fishes in the world."""

    places: Array  # (n, k, 3) cm
    normals: Array  # (n, k, 3) of the skin
    apart_cm: Array  # (n, k) from flank to flank, of those that lie between
    present: Bools  # (n, k) False for those of fins that a species lacks


def keypoints_at(
    shape: FishShape, kinds: Ints, instances: Array, control_points: Array
) -> KeypointsIn:
    """Compute the keypoints of instances (n, 30) of the species `kinds` (n,)."""
    drawn = shape.at(instances, control_points)
    n, k = len(instances), len(NAMES)
    rows = kinds[:, None] * k * SIDES + np.arange(k * SIDES)
    each = np.arange(n)[:, None]
    both = drawn.places[each, rows].reshape(n, k, SIDES, 3).astype(np.float64)
    normals = drawn.normals[each, rows].reshape(n, k, SIDES, 3)
    present = shape.present[kinds[:, None], rows].reshape(n, k, SIDES)
    apart = np.linalg.norm(both[:, :, 0] - both[:, :, 1], axis=-1)
    return KeypointsIn(both.mean(axis=2), normals[:, :, 0], apart, present.all(axis=2))


def _vertices(plan: SurfacePlan, tips: list[_Place]) -> tuple[Array, Array]:
    """The vertices (2 k, 16) of all keypoints, left then right, and their data (2 k, 4)."""
    rest = rest_control_points(plan, 1.0, 0.0)
    eye = _Place(*eye_place(plan))
    at: dict[str, tuple[_Place | None, str]] = {
        "snout": (_Place(0.5, 0.0), "both"),
        "left_eye": (eye, "left"),
        "right_eye": (eye, "right"),
        "tail_root": (_ridge(rest, 0.5, plan.tail.begin), "both"),
        "upper_tail_tip": (tips[0], "both"),
        "lower_tail_tip": (tips[1], "both"),
    }
    for name, fin, u in (("dorsal", plan.dorsal, 0.0), ("anal", plan.ventral, 1.0)):
        ends = fin.base if fin else (None, None)
        for end, along in zip(("front", "rear"), ends, strict=True):
            at[f"{name}_{end}"] = (None if along is None else _ridge(rest, u, along)), "both"
    rows, own = [], []
    for name in NAMES:
        for flank in (LEFT, RIGHT):
            if name not in at:
                flank = LEFT if name.startswith("left") else RIGHT
                pectoral = name.endswith("pectoral")
                paddle = plan.pectoral if pectoral else plan.pelvic
                row, one = _paddle(rest, paddle, PECTORAL if pectoral else PELVIC, flank)
            else:
                place, which = at[name]
                if which != "both":
                    flank = LEFT if which == "left" else RIGHT
                row, one = _vertex(rest, place, flank)
            rows.append(row)
            own.append(one)
    return np.array(rows), np.array(own)


def _ridge(rest: Array, u: float, along: float) -> _Place:
    """The place in the row `u` of a flank that lies `along` behind the snout, body lengths."""
    v = np.linspace(0.0, 1.0, SAMPLES)
    row = dense(basis_at(U, np.array([u])), U)[0] @ rest[RIGHT].reshape(U, V, 3)[..., 0].reshape(
        U, V
    )
    behind = -dense(basis_at(V, v), V) @ row
    return _Place(u, float(v[np.abs(behind - along).argmin()]))


def _vertex(rest: Array, place: _Place | None, flank: slice) -> tuple[Array, Array]:
    """The vertex (16,) and data (4,) at a place of a flank; None: the fin is absent."""
    if place is None:
        return np.zeros(VERTEX_COLUMNS), np.array([0.0, 0.0, ABSENT, 0.0])
    vertices, own = _on_flank(rest, np.array([place.u]), np.array([place.v]), flank)
    return vertices[0], own[0]


def _on_flank(rest: Array, u: Array, v: Array, flank: slice) -> tuple[Array, Array]:
    """The vertices (n, 16) and data (n, 4) at parameters u and v (n,) of a flank."""
    across, along = basis_at(U, u), basis_at(V, v)
    out = np.zeros((len(u), VERTEX_COLUMNS))
    out[:, 0:3], out[:, 3:6] = across.weight, along.weight
    out[:, 6:9], out[:, 9:12] = across.slope, along.slope
    out[:, 12], out[:, 13], out[:, 14] = BODY, u, -1.0 if flank == LEFT else 1.0
    out[:, 15] = V
    base = flank.start + across.first * V + along.first
    points = surface_points(rest, out, base)
    return out, np.column_stack([-points[:, 0], points[:, 1], base, v])


def _paddle(rest: Array, plan: PaddlePlan | None, part: int, flank: slice) -> tuple[Array, Array]:
    out = np.zeros(VERTEX_COLUMNS)
    out[12], out[14] = part, -1.0 if flank == LEFT else 1.0
    if plan is None:
        return out, np.array([0.0, 0.0, ABSENT, 0.0])
    return out, np.array([0.0, 0.0, flank.start + root_point(plan, rest[flank]), 0.5])
