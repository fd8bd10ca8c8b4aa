"""Structured light: pictures that tell a camera which pixel of a projector lights a point.

Each projector in turn shows uniform pictures and the bits of a Gray code of its columns and of its
rows, each bit with its inverse, while all others are black. Neighbouring stripes differ in one bit,
so a bit that is misread between two stripes is wrong by one stripe at most.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Bytes, Ints
from subsea.view.rig import TONE, CameraRig, Projection, Rect, Weave

STRIPE_PX = 2  # width of the narrowest stripe
GREYS = 96, 176  # code values of grey pictures, which tell the gamma
COLUMNS, ROWS = 0, 1  # axes of stripes


class LightPattern(NamedTuple):
    """One picture of the structured light of a projector."""

    name: str
    colour: tuple[int, int, int] = (255, 255, 255)  # of a uniform picture
    axis: int | None = None  # of stripes; None: uniform
    bit: int = 0  # of the Gray code, 0 for the narrowest stripes
    inverse: bool = False


UNIFORM = (
    LightPattern("white"),
    LightPattern("black", (0, 0, 0)),
    LightPattern("red", (255, 0, 0)),
    LightPattern("green", (0, 255, 0)),
    LightPattern("blue", (0, 0, 255)),
    *(LightPattern(f"grey-{code}", (code, code, code)) for code in GREYS),
)


def light_patterns(size: tuple[int, int]) -> tuple[LightPattern, ...]:
    """The pictures of a projector of `size` (width, height) pixels, in the order they are shown."""
    stripes = [
        LightPattern(f"{word}-{STRIPE_PX << bit}{'-inverse' * inverse}", (255, 255, 255), axis,
                     bit, inverse)
        for axis, word in ((COLUMNS, "columns"), (ROWS, "rows"))
        for bit in reversed(range(bits(size[axis])))
        for inverse in (False, True)
    ]  # fmt: skip
    return (*UNIFORM, *stripes)


def bits(pixels: int) -> int:
    """The number of bits of the Gray code of a number of columns or rows."""
    return max((-(-pixels // STRIPE_PX) - 1).bit_length(), 1)


def gray(number: Ints) -> Ints:
    """Encode numbers in the Gray code (Gray, US patent 2632058)."""
    return np.asarray(number ^ (number >> 1))


def from_gray(code: Ints) -> Ints:
    """Decode numbers of at most 32 bits from the Gray code."""
    number = code.copy()
    for shift in (16, 8, 4, 2, 1):
        number ^= number >> shift
    return number


def light_picture(pattern: LightPattern, size: tuple[int, int]) -> Bytes:
    """Draw a pattern (h, w, 3), top row first, for a projector of `size` pixels."""
    width, height = size
    if pattern.axis is None:
        return np.broadcast_to(np.array(pattern.colour, np.uint8), (height, width, 3))
    code = gray(np.arange(size[pattern.axis]) // STRIPE_PX)
    lit = ((code >> pattern.bit) & 1 == 1) != pattern.inverse
    line = np.where(lit, np.uint8(255), np.uint8(0))
    line = line[None, :, None] if pattern.axis == COLUMNS else line[:, None, None]
    return np.broadcast_to(line, (height, width, 3))


def bare(rig: CameraRig) -> CameraRig:
    """The rig without warps, masks, adjustments and eyes.

    Each channel shows a picture pixel by pixel. The pictures of the channels lie side by side from
    the lower left corner.
    """
    patches, left = [], 0
    for patch in rig.patches:
        source: Rect = (left, 0, *patch.place[2:])
        left += patch.place[2]
        patches.append(
            patch._replace(
                left=source, right=source, weave=Weave.PLAIN, shape=Projection.FLAT,
                squeezed=(1.0, 1.0), warp=None, mask=None, adjustment=None, gamma=TONE,
            )
        )  # fmt: skip
    return rig._replace(patches=tuple(patches))


def lit_picture(rig: CameraRig, channel: int, number: int) -> Bytes:
    """The picture (h, w, 3) of a `bare` rig while a channel shows its pattern of this number.

    All other channels are black. The number counts from 0; beyond the last pattern all is black.
    """
    width = sum(patch.place[2] for patch in rig.patches)
    height = max(patch.place[3] for patch in rig.patches)
    picture = np.zeros((height, width, 3), np.uint8)
    for patch in rig.patches:
        size = patch.place[2:]
        patterns = light_patterns((size[0], size[1]))
        if patch.channel == channel and number < len(patterns):
            left = patch.left[0]
            picture[height - size[1] :, left : left + size[0]] = light_picture(
                patterns[number], (size[0], size[1])
            )
    return picture
