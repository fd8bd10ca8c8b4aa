"""Where pictures go: a film, one picture, or a folder of them. Whole files, or none.

A theatre has several windows, each with a reel of its own beside the others.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.core.atomic_io import check_file, check_folder, is_folder, replacing
from subsea.core.errors import UserError
from subsea.media.video_metadata import NO_TAGS, Tags, insert

# (height, width, 3) of 8 bits, top row first; in folders also (height, width) of 16 bits
Picture = NDArray[np.uint8] | NDArray[np.uint16]
Write = Callable[[int, Picture], None]  # the number of the frame, and what it shows
WriteAll = Callable[[int, Mapping[str, Picture]], None]  # by the names of the windows

QUALITY = "19"  # x264's constant rate factor: near-transparent, small enough to mail
TELEVISION = (24, 30, 48, 60, 120)  # rates that are often meant to be 0.1% less
KINDS = "FILE.mp4, FILE.png or a folder's name without a suffix"


def kind_of(out: Path) -> str:
    """What the name asks for: "film", "picture" or "folder"; another suffix is a UserError."""
    kinds = {".mp4": "film", ".png": "picture", "": "folder"}
    kind = "folder" if is_folder(out) else kinds.get(out.suffix.lower())
    if kind is None:
        raise UserError(f"{out}: cannot write {out.suffix!r}, expected {KINDS}")
    return kind


def check_reel(out: Path) -> str:
    """The kind of `out`; a place that cannot be written to is a UserError."""
    kind = kind_of(out)
    (check_folder if kind == "folder" else check_file)(out)
    return kind


def frame_rate(fps: float) -> Fraction:
    """The exact rate that is meant: 29.97 is 30000/1001, as television has it."""
    for whole in TELEVISION:
        if abs(fps - whole / 1.001) < 0.005:
            return Fraction(1000 * whole, 1001)
    return Fraction(fps).limit_denominator(1001)


def fitting(kind: str, size: tuple[int, int]) -> tuple[int, int]:
    """The largest size within `size` that such a reel can hold."""
    even = kind == "film"  # yuv420p halves both sides
    return (size[0] - size[0] % 2, size[1] - size[1] % 2) if even else size


def place_of(out: Path, window: str) -> Path:
    """Where the pictures of a window go: `out`/left or out-left.mp4; of one without name `out`."""
    if not window:
        return out
    return out / window if kind_of(out) == "folder" else out.with_stem(f"{out.stem}-{window}")


def written_to(out: Path, windows: Iterable[str]) -> str:
    """The files that hold the pictures of those windows, in words; of a folder its own name."""
    if kind_of(out) == "folder":
        return str(out)
    return ", ".join(str(place_of(out, window)) for window in windows)


def frame_file(folder: Path, number: int) -> Path:
    """The file of a frame in a folder of numbered pictures."""
    return folder / f"frame_{number:05d}.png"


@contextmanager
def open_reels(
    out: Path, sizes: Mapping[str, tuple[int, int]], rate: Fraction, tags: Tags = NO_TAGS
) -> Iterator[WriteAll]:
    """The writer of pictures of those `sizes`, by the names of windows; see `place_of`.

    Films have `tags` for their players.
    """
    with ExitStack() as stack:
        writers = {
            name: stack.enter_context(_open_reel(place_of(out, name), size, rate, tags))
            for name, size in sizes.items()
        }

        def write(number: int, pictures: Mapping[str, Picture]) -> None:
            for name, picture in pictures.items():
                writers[name](number, picture)

        yield write


def _open_reel(
    out: Path, size: tuple[int, int], rate: Fraction, tags: Tags
) -> AbstractContextManager[Write]:
    """The writer that fits the name `out`."""
    kind = check_reel(out)
    if kind == "film":
        return film_reel(out, size, rate, tags)
    if kind == "picture":
        return picture_reel(out)
    return folder_reel(out)


@contextmanager
def film_reel(
    out: Path, size: tuple[int, int], rate: Fraction, tags: Tags = NO_TAGS
) -> Iterator[Write]:
    """An H.264 film that plays everywhere: yuv420p, index first. The size must be even.

    An interruption closes the film after the pictures so far; a fault leaves nothing.
    """
    import av  # here: a simulation or a window has no need of it

    interrupted: KeyboardInterrupt | None = None
    # x264's macroblock tree reads memory that nothing has been written to: with it hardly two films
    # of the same pictures are the same. Without it they are 3% larger.
    encoding = {"mbtree": 0} | ({} if tags.packing is None else {"frame-packing": tags.packing})
    parameters = ":".join(f"{name}={value}" for name, value in encoding.items())
    options = {"crf": QUALITY, "preset": "veryfast", "x264-params": parameters}
    frames = 0
    with replacing(out) as temporary:
        with av.open(
            str(temporary), "w", format="mp4", options={"movflags": "+faststart"}
        ) as container:
            stream: Any = container.add_stream("libx264", rate=rate, options=options)
            stream.width, stream.height = size
            stream.pix_fmt = "yuv420p"

            def write(number: int, picture: Picture) -> None:
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
        if tags.boxes:
            insert(temporary, tags.boxes)
    if interrupted:
        raise interrupted


@contextmanager
def picture_reel(out: Path) -> Iterator[Write]:
    """One PNG."""
    yield lambda number, picture: write_png(out, picture)


@contextmanager
def folder_reel(out: Path) -> Iterator[Write]:
    """PNGs named frame_00000.png and on."""
    yield lambda number, picture: write_png(frame_file(out, number), picture)


def write_png(path: Path, picture: Picture) -> None:
    """Write one picture, whole or not at all; what the disk says against it is a UserError."""
    from PIL import Image

    with replacing(path) as temporary:
        Image.fromarray(picture).save(temporary, format="PNG")
