"""The photographs of structured light: their folders, their order, and what is wrong with them."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageOps

from subsea.base.arrays import Array, Bytes
from subsea.base.errors import UserError, unreadable
from subsea.base.pictures import in_srgb, naming_faults
from subsea.stage.theatre.channels import ProjectorChannel
from subsea.view.structured_light import LightPattern, light_patterns

SUFFIXES = ".jpg", ".jpeg", ".png", ".tif", ".tiff", ".bmp", ".webp"
_CODES = np.arange(256) / 255.0
# The linear light of code values (IEC 61966-2-1).
_LIGHT = np.where(_CODES <= 0.04045, _CODES / 12.92, ((_CODES + 0.055) / 1.055) ** 2.4).astype("f4")
MAX_PIXELS = 2**27  # of a photograph
POINTS = "points.toml"  # beside the photographs of a camera


class LightStep(NamedTuple):
    """One step of the structured light: a channel shows one of its patterns."""

    channel: int  # number of the channel in the theatre
    name: str  # of the channel
    number: int  # of the pattern, from 0
    pattern: LightPattern

    @property
    def words(self) -> str:
        """The pattern and its channel, for messages."""
        return f"{self.pattern.name} of {self.name!r}"


def light_steps(channels: Sequence[ProjectorChannel], shrink: int = 1) -> tuple[LightStep, ...]:
    """All pictures that the projectors of a theatre show, one after another.

    Windows have `shrink` times fewer pixels a side.
    """
    return tuple(
        LightStep(number, channel.name, k, pattern)
        for number, channel in enumerate(channels)
        for k, pattern in enumerate(
            light_patterns((channel.place[2] // shrink, channel.place[3] // shrink))
        )
    )


def camera_folders(folder: Path) -> list[Path]:
    """The folders of photographs, one for each camera: those in `folder`, or itself."""
    try:
        inner = sorted(path for path in folder.iterdir() if path.is_dir() and _photographs(path))
    except OSError as fault:
        raise unreadable(folder, fault) from fault
    own = bool(_photographs(folder))
    if own and inner:
        raise UserError(
            f"photographs here and in {inner[0].name}; expected either those of one camera, or a "
            "folder for each camera",
            file=folder,
        )
    if not own and not inner:
        raise UserError(f"no photographs ({', '.join(SUFFIXES)})", file=folder)
    return inner or [folder]


def ordered(folder: Path, steps: Sequence[LightStep]) -> list[Path]:
    """The photographs of a camera in the order of their names, one for each step.

    A UserError names the place where one is missing or too many.
    """
    paths = sorted(_photographs(folder), key=_natural)
    if len(paths) != len(steps):
        raise UserError(
            f"{len(paths)} photographs, expected {len(steps)}: {_first_break(paths, steps)}",
            file=folder,
        )
    return paths


def read_photograph(path: Path) -> Bytes:
    """Read a photograph (h, w, 3) in sRGB, upright as programs show it."""
    with naming_faults("photograph", path), Image.open(path) as image:
        if image.width * image.height > MAX_PIXELS:
            message = f"{image.width}×{image.height} pixels, expected {MAX_PIXELS} at most"
            raise UserError(message, file=path)
        return np.asarray(in_srgb(ImageOps.exif_transpose(image)).convert("RGB"))


def _photographs(folder: Path) -> list[Path]:
    return [path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES]


def _natural(path: Path) -> list[tuple[int, str]]:
    """A key that sorts numbers in names by their value."""
    parts = re.findall(r"\d+|\D+", path.name.lower())
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


def _first_break(paths: Sequence[Path], steps: Sequence[LightStep]) -> str:
    """Find where the photographs stop to follow the steps, in words.

    A bit and its inverse light each point once. So their light adds up to that of white and black.
    """
    white = black = None
    before: tuple[Array, Path] | None = None
    for path, step in zip(paths, steps, strict=False):
        now = _small(path)
        if before is not None and now.shape != before[0].shape:
            return f"{path.name} has another size than {before[1].name}"
        if step.pattern.name == "white":
            white = now
        elif step.pattern.name == "black":
            black = now
        elif (
            step.pattern.inverse and white is not None and black is not None and before
            and mismatch(white, black, before[0], now) > MOST_MISMATCH
        ):  # fmt: skip
            if np.abs(before[0] - now).mean() < 0.2 * np.abs(white - black).mean():
                return f"{path.name} and {before[1].name} show the same; remove one"
            return f"near {path.name} one is missing or too many (expected {step.words})"
        before = now, path
    if len(paths) < len(steps):
        return f"the last ones are missing, from {steps[len(paths)].words}"
    return f"from {paths[len(steps)].name} on there is nothing left to show"


MOST_MISMATCH = 0.2  # share of the lit pixels that may contradict a pair of photographs


def mismatch(white: Array, black: Array, picture: Array, inverse: Array) -> float:
    """The share of lit pixels at which a bit and its inverse do not make up white and black.

    All are linear light (h, w).
    """
    contrast = white - black
    lit = contrast > max(0.3 * float(contrast.max()), 0.005)
    if not lit.any():
        return 0.0
    both = picture[lit] + inverse[lit] - white[lit] - black[lit]
    return float(np.mean(np.abs(both) > 0.5 * contrast[lit]))


def light_of(picture: Bytes) -> Array:
    """The linear light (h, w, 3) of a photograph, 0 to 1."""
    return np.asarray(_LIGHT[picture])


def _small(path: Path) -> Array:
    """The brightness (h, w) of a photograph, with at most some 600 pixels a side."""
    grey = light_of(read_photograph(path)).mean(axis=2)
    step = max(max(grey.shape) // 600, 1)
    rows, columns = (side // step * step for side in grey.shape)
    parts = grey[:rows, :columns].reshape(rows // step, step, columns // step, step)
    return np.asarray(parts.mean(axis=(1, 3)))
