"""Roughness and metal of a fish's skin, from the reflectances with which the dive draws it.

glTF and USD have no reflectance of scales: rough skin stands for a little of it, metal for silver.
"""

import numpy as np

from subsea.base.arrays import Bytes
from subsea.export.clips import Model
from subsea.fish.raster import from_srgb, smoothstep

DULL, SHINY = 0.65, 0.20  # roughness of skin without gloss, and of a gloss of 1
PALE = 0.05, 0.5  # least of red, green and blue (linear) where silver begins and is whole
STEP = 2  # texels of the colours to one of the metal, along a side


def roughness(model: Model) -> float:
    """Return the roughness (GGX, perceptual) of a skin, from 0 to 1."""
    return round(DULL + (SHINY - DULL) * model.gloss, 3)


def metal_image(model: Model) -> Bytes | None:
    """Compute roughness and metal of the body as an image (h, w, 3), bottom row first.

    As in glTF, green is the roughness and blue the metal. What is bright and without colour is
    silver, as in `shaders/fishes.frag`. Without silver there is none.
    """
    if not model.silver:
        return None
    least = from_srgb(model.sheet[::STEP, ::STEP, :3] / 255.0).min(axis=-1)
    image = np.zeros((*least.shape, 3), np.uint8)
    image[..., 1] = round(255 * roughness(model))
    image[..., 2] = np.round(255 * model.silver * smoothstep(least, *PALE))
    return image
