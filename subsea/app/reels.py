"""Where pictures go: a film, one picture, or a folder of them. Whole files, or none."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.errors import UserError
from subsea.places import check_file, check_folder, is_folder, replacing

Picture = NDArray[np.uint8]  # (height, width, 3), top row first
Write = Callable[[Picture], None]

QUALITY = "19"  # x264's constant rate factor: near-transparent, small enough to mail
KINDS = "FILE.mp4, FILE.png or a folder's name without a suffix"


def kind_of(out: Path) -> str:
    """What the name asks for: "film", "picture" or "folder"; another suffix is a UserError."""
    kinds = {".mp4": "film", ".png": "picture", "": "folder"}
    kind = "folder" if is_folder(out) else kinds.get(out.suffix.lower())
    if kind is None:
        raise UserError(f"{out}: cannot write {out.suffix!r}, expected {KINDS}")
    return kind


def check_reel(out: Path) -> str:
    """The kind of `out`; a place that cannot be written to, or that is taken, is a UserError."""
    kind = kind_of(out)
    if kind != "folder":
        check_file(out)
        return kind
    check_folder(out)
    if any(out.glob("frame_*.png")):
        raise UserError(f"{out}: holds numbered pictures already, name another folder")
    return kind


def open_reel(out: Path, size: tuple[int, int], fps: float) -> AbstractContextManager[Write]:
    """The writer that fits the name `out`, see `check_reel`."""
    kind = check_reel(out)
    if kind == "film":
        return film_reel(out, size, fps)
    if kind == "picture":
        return picture_reel(out)
    return folder_reel(out)


@contextmanager
def film_reel(out: Path, size: tuple[int, int], fps: float) -> Iterator[Write]:
    """An H.264 film that plays everywhere: yuv420p, index first. The size must be even.

    An interruption closes the film after the pictures so far; a fault leaves nothing.
    """
    import av  # here: a simulation or a window has no need of it

    interrupted: KeyboardInterrupt | None = None
    frames = 0
    with (
        replacing(out) as temporary,
        av.open(str(temporary), "w", format="mp4", options={"movflags": "+faststart"}) as container,
    ):
        stream: Any = container.add_stream(
            "libx264",
            rate=Fraction(fps).limit_denominator(1001),
            options={"crf": QUALITY, "preset": "veryfast"},
        )
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"

        def write(picture: Picture) -> None:
            nonlocal frames
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
            frames += 1

        try:
            yield write
        except KeyboardInterrupt as interrupt:
            if not frames:
                raise
            interrupted = interrupt
        container.mux(stream.encode(None))
    if interrupted:
        raise interrupted


@contextmanager
def picture_reel(out: Path) -> Iterator[Write]:
    """One PNG."""
    yield lambda picture: _write_png(out, picture)


@contextmanager
def folder_reel(out: Path) -> Iterator[Write]:
    """PNGs named frame_00000.png and on."""
    count = 0

    def write(picture: Picture) -> None:
        nonlocal count
        _write_png(out / f"frame_{count:05d}.png", picture)
        count += 1

    yield write


def _write_png(path: Path, picture: Picture) -> None:
    from PIL import Image

    with replacing(path) as temporary:
        Image.fromarray(picture).save(temporary, format="PNG")
