"""Convert axes and units, write the licence notice, and encode textures as PNG or WebP."""

import io
from collections.abc import Iterable

import numpy as np
from PIL import Image

from subsea.base.arrays import Array, Bytes
from subsea.fish.species import is_shipped
from subsea.geometry.rotation import from_matrix

# Body axes are x anterior, y dorsal, z right; lengths are in cm.
METRES = 0.01
# Rows are the new axes. glTF and USD: x left, y up, z ahead.
Y_UP = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
# Blender converts (x, y, z) of glTF to (x, -z, y): x left, y back, z up.
Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]) @ Y_UP
# The world of the dive has z up; rows are the axes of a world with y up: x, z, -y.
WORLD_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])

HOLDER = "Copyright (c) 2026 The subsea authors"  # as in LICENSE
SENTENCE = "MIT licence: use, change and sell it, and keep this notice."
WEBP_QUALITY = 92  # of 100; opacity has no losses


def to_metres(points: Array, axes: Array) -> Array:
    """Convert points (..., 3) in cm to metres along other axes."""
    return np.asarray(METRES * (points @ axes.T))


def rotate_quaternions(rotation: Array, axes: Array) -> Array:
    """Convert quaternions (..., 4), w first, to other axes."""
    return np.concatenate([rotation[..., :1], rotation[..., 1:] @ axes.T], axis=-1)


def world_rotations(rotation: Array, axes: Array | None = None) -> Array:
    """Convert rotations (..., 4) to the world of the dive into those to a world with y up.

    `axes` are the new axes of what is rotated, such as `Y_UP` for a fish; None keeps its own, as
    for a camera.
    """
    w, x, y, z = from_matrix(WORLD_Y_UP)
    before = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])
    if axes is not None:
        w, x, y, z = from_matrix(axes.T)
        after = np.array([[w, -x, -y, -z], [x, w, z, -y], [y, -z, w, x], [z, y, -x, w]])
        before = before @ after
    return np.asarray(rotation @ before.T)


def continuous(rotation: Array) -> Array:
    """Give quaternions (T, ..., 4) the signs that make each the nearest to the one before it."""
    dots = (rotation[1:] * rotation[:-1]).sum(axis=-1, keepdims=True)
    signs = np.cumprod(np.where(dots < 0.0, -1.0, 1.0), axis=0)
    return np.concatenate([rotation[:1], signs * rotation[1:]])


def copyright_line(species: Iterable[str] = ()) -> str:
    """Name the holder of the rights in a file with these species, and the licence.

    Species that the user made are the user's, with their skins; motion and sea are ours.
    """
    users = sorted({name for name in species if not is_shipped(name)})
    theirs = f" Shapes and skins of {', '.join(users)}: their author." if users else ""
    return f"{HOLDER}. {SENTENCE}{theirs}"


def sheet_png(sheet: Bytes) -> bytes:
    """Encode a texture (h, w, 3 or 4), bottom row first."""
    file = io.BytesIO()
    Image.fromarray(sheet[::-1]).save(file, "PNG")
    return file.getvalue()


def sheet_webp(sheet: Bytes, exact: bool = False) -> bytes:
    """Encode a texture (h, w, 3 or 4), bottom row first, a sixth as large and with losses.

    `exact`: without losses, as directions need it.
    """
    file = io.BytesIO()
    Image.fromarray(sheet[::-1]).save(file, "WEBP", quality=WEBP_QUALITY, lossless=exact)
    return file.getvalue()
