"""Retina pictures of a fish: identities of pixels as values and colours; brightness."""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Ints
from subsea.frame.packet import pack
from subsea.rendering.gl.id_buffer import KINDS, IdMaps
from subsea.rendering.renderer import Renderer
from subsea.view.retina import FishEyes, retina_rig, retinal_views
from subsea.world.world import World

SIDES = "left", "right"
# Values of identity maps: of the first of each kind.
VALUES = {
    "water": 0, "surface": 1, "seabed": 2, "seaweed": 3, "bubbles": 4, "hook": 5,
    "pillar": 100, "rock": 300, "coral": 1000, "fish": 10000,
}  # fmt: skip
FIRST = np.array([VALUES[kind] for kind in KINDS], np.int32)
MOST_FISHES = 2**16 - VALUES["fish"]  # with values of their own in 16 bits
PLAIN = {
    "surface": (0.20, 0.24, 0.24), "seabed": (0.42, 0.38, 0.26), "seaweed": (0.16, 0.46, 0.14),
    "bubbles": (0.90, 0.90, 0.90), "hook": (0.95, 0.90, 0.20),
}  # fmt: skip
SEEN_SIZE = 48, 48  # pixels of the retinae whose brightness is measured


def retina_brightness(renderer: Renderer, world: World, by: FishEyes) -> float:
    """Mean brightness in [0, 1] of both retinae in the current tick, looking ahead (Tu §6.2).

    The mean of the two pictures as a screen shows them. It depends only on the world and the
    renderer's quality, and leaves the renderer as it was.
    """
    rig = retina_rig(SEEN_SIZE, by.half_cm)
    with renderer.apart(rig):
        renderer.draw(pack(world, retinal_views(world, by, rig, 1.0), 1.0))
        return float(np.mean([renderer.read_pixels(side) for side in range(len(SIDES))]) / 255.0)


def velocity_of(world: World, fish: int) -> tuple[float, float, float]:
    """The velocity of a fish, cm/s, in world axes."""
    x, y, z = world.state.fishes.velocity[fish].tolist()
    return x, y, z


def values_of(seen: IdMaps) -> Ints:
    """The values (h, w) of an identity map."""
    return np.asarray(FIRST[seen.kind] + seen.number)


def coded(value: Ints) -> NDArray[np.uint8]:
    """Colours (h, w, 3) of identities (h, w): fishes red, solids blue (Tu §6.7)."""
    # Successive numbers get different shades.
    shade = 0.35 + 0.65 * (value * 0.6180339887 % 1.0)
    tint = value * 0.7548776662 % 1.0
    red = np.stack([shade, 0.45 * tint * shade, 0.25 * shade], axis=-1)
    blue = np.stack([0.25 * tint * shade, 0.45 * tint * shade, shade], axis=-1)
    violet = np.stack([0.45 * shade, 0.75 * tint * shade, shade], axis=-1)
    rgb = np.zeros((*value.shape, 3))
    for name, colour in PLAIN.items():
        rgb[value == VALUES[name]] = colour
    for name, colours in (("pillar", blue), ("coral", violet), ("fish", red)):
        rgb = np.where((value >= VALUES[name])[..., None], colours, rgb)
    return np.asarray(np.rint(255.0 * rgb), np.uint8)


@cache
def codes() -> NDArray[np.uint8]:
    """The colours (65536, 3) of all values of a 16-bit map."""
    return coded(np.arange(2**16))
