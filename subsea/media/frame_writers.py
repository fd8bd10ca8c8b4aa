"""Write frames as a film, a picture or a folder of pictures, each file atomically.

Each window of a theatre has its own output beside the others.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.base.atomic_io import check_folder, is_folder, replacing
from subsea.base.errors import UserError
from subsea.base.file_kinds import FILM, PICTURE, check_results
from subsea.media.film_sound import FilmSound
from subsea.media.video_metadata import NO_METADATA, VideoMetadata, insert_boxes
from subsea.sound.space import RATE

# (height, width, 3) of 8 bits, top row first; in folders also (height, width) of 16 bits.
Picture = NDArray[np.uint8] | NDArray[np.uint16]
Write = Callable[[int, Picture], None]  # of a frame by its number
WriteAll = Callable[[int, Mapping[str, Picture]], None]  # of all windows by name

QUALITY = "19"  # x264's constant rate factor: near-transparent, small enough to mail
BITS_S = 96_000  # of each channel of sound
TELEVISION = (24, 30, 48, 60, 120)  # nominal rates; broadcasts are 0.1% slower
KINDS = "FILE.mp4, FILE.png or a folder's name without a suffix"


def kind_of(out: Path) -> str:
    """The kind of output by its name: "film", "picture" or "folder", else a UserError."""
    kinds = {".mp4": "film", ".png": "picture", "": "folder"}
    kind = "folder" if is_folder(out) else kinds.get(out.suffix.lower())
    if kind is None:
        raise UserError(f"cannot write {out.suffix!r}, expected {KINDS}", file=out)
    return kind


def check_output(out: Path, windows: Iterable[str] = ("",), force: bool = False) -> None:
    """Raise a UserError if the output of a window cannot be written or would replace another kind.

    With `force` a file of any kind may be replaced.
    """
    kind = kind_of(out)
    if kind == "folder":
        check_folder(out)
    else:
        files = [window_path(out, window) for window in windows]
        check_results(files, FILM if kind == "film" else PICTURE, force)


def frame_rate(fps: float) -> Fraction:
    """The exact rate: 29.97 is 30000/1001, as in television."""
    for whole in TELEVISION:
        if abs(fps - whole / 1.001) < 0.005:
            return Fraction(1000 * whole, 1001)
    return Fraction(fps).limit_denominator(1001)


def fitted_size(kind: str, size: tuple[int, int]) -> tuple[int, int]:
    """The largest size within `size` that this kind of output can hold."""
    even = kind == "film"  # yuv420p halves both sides
    return (size[0] - size[0] % 2, size[1] - size[1] % 2) if even else size


def window_path(out: Path, window: str) -> Path:
    """Path of a window's pictures: `out`/left or out-left.mp4, or `out` for the window ""."""
    if not window:
        return out
    return out / window if kind_of(out) == "folder" else out.with_stem(f"{out.stem}-{window}")


def output_names(out: Path, windows: Iterable[str]) -> str:
    """The output files of these windows for a message; a folder is only named itself."""
    if kind_of(out) == "folder":
        return str(out)
    return ", ".join(str(window_path(out, window)) for window in windows)


def frame_file(folder: Path, number: int) -> Path:
    """Path of a frame in a folder of numbered pictures."""
    return folder / f"frame_{number:05d}.png"


@contextmanager
def open_writers(
    out: Path,
    sizes: Mapping[str, tuple[int, int]],
    rate: Fraction,
    metadata: VideoMetadata = NO_METADATA,
    sound: FilmSound | None = None,
) -> Iterator[WriteAll]:
    """Open a writer for pictures of these `sizes` by the names of windows, see `window_path`.

    Films have `sound`.
    """
    with ExitStack() as stack:
        writers = {
            name: stack.enter_context(
                _open_writer(window_path(out, name), size, rate, metadata, sound)
            )
            for name, size in sizes.items()
        }

        def write(number: int, pictures: Mapping[str, Picture]) -> None:
            for name, picture in pictures.items():
                writers[name](number, picture)

        yield write


def _open_writer(
    out: Path, size: tuple[int, int], rate: Fraction, metadata: VideoMetadata,
    sound: FilmSound | None,
) -> AbstractContextManager[Write]:  # fmt: skip
    kind = kind_of(out)
    if kind == "film":
        return film_writer(out, size, rate, metadata, sound)
    if kind == "picture":
        return nullcontext(lambda number, picture: write_png(out, picture))
    return nullcontext(lambda number, picture: write_png(frame_file(out, number), picture))


@contextmanager
def film_writer(
    out: Path, size: tuple[int, int], rate: Fraction, metadata: VideoMetadata = NO_METADATA,
    sound: FilmSound | None = None,
) -> Iterator[Write]:  # fmt: skip
    """Write an H.264 film that plays everywhere: yuv420p, index first. The size must be even.

    With `sound` it has a track of AAC.

    An interruption closes the film after the pictures so far; an error leaves no file.
    """
    import av  # here: simulations and windows do not need it

    interrupted: KeyboardInterrupt | None = None
    # x264's macroblock tree reads uninitialised memory: films of the same pictures would differ.
    # Without it they are 3% larger.
    encoding = {"mbtree": 0}
    if metadata.packing is not None:
        encoding["frame-packing"] = metadata.packing
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
            add_sound = _sound_track(container, sound)

            def write(number: int, picture: Picture) -> None:
                nonlocal frames
                container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
                frames += 1
                add_sound(float(frames / rate))

            try:
                yield write
            except KeyboardInterrupt as interrupt:
                if not frames:
                    raise
                interrupted = interrupt
            container.mux(stream.encode(None))
            add_sound(float(frames / rate))
            add_sound(None)
        if metadata.boxes:
            insert_boxes(temporary, metadata.boxes)
    if interrupted:
        raise interrupted


def _sound_track(container: Any, sound: FilmSound | None) -> Callable[[float | None], None]:
    """Add a track of AAC; returns a function that fills it up to a time, s, and ends it at None."""
    if sound is None:
        return lambda until: None
    import av

    track: Any = container.add_stream("aac", rate=RATE, layout=sound.layout.container_name)
    track.bit_rate = BITS_S * sound.layout.channels
    read, at = sound.reader(), 0

    def add(until: float | None) -> None:
        nonlocal at
        if until is None:
            container.mux(track.encode(None))
            return
        samples = read(until)
        if len(samples):
            planes = np.ascontiguousarray(samples.T)
            frame = av.AudioFrame.from_ndarray(
                planes, format="fltp", layout=sound.layout.container_name
            )
            frame.sample_rate, frame.pts, frame.time_base = RATE, at, Fraction(1, RATE)
            at += len(samples)
            container.mux(track.encode(frame))

    return add


def write_png(path: Path, picture: Picture) -> None:
    """Write one picture completely or not at all; a UserError if the disk refuses."""
    from PIL import Image

    with replacing(path) as temporary:
        Image.fromarray(picture).save(temporary, format="PNG")
