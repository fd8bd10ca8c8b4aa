"""Write frames as a film, a picture or a folder of pictures, each file atomically.

Each window of a theatre has its own output beside the others. Metadata mark a film for players.
Stereo: the frame packing message of H.264, which switches televisions, and the box `st3d`, which
players on computers read. 360°: the box `sv3d` ("spherical video V2" by Google). ffmpeg's muxer
writes these boxes only for input from a demuxer, so they are inserted into the complete file.
"""

import shutil
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from fractions import Fraction
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np

from subsea import __version__
from subsea.base.errors import UserError, unknown
from subsea.base.file_kinds import FILM, LIGHT, PICTURE, check_results
from subsea.base.files import check_folder, create_part, is_folder, replacing
from subsea.base.pictures import Pixels, write_png
from subsea.media.film_sound import FilmSound
from subsea.sound.space import AMBISONIC, RATE


class VideoMetadata(NamedTuple):
    """Frame packing and boxes of a film."""

    packing: int | None = None  # of Annex D of H.264; None: every frame is one picture
    boxes: bytes = b""  # for the sample description of the pictures


class FilmCodec(NamedTuple):
    """The coding of the pictures of a film, and of its sound."""

    encoder: str
    pixels: str  # format of the coded pictures
    options: dict[str, str]
    containers: tuple[str, ...]  # suffixes of files
    tag: str = ""  # of the pictures in the file, if players want another than ffmpeg's
    sound: str = "aac"
    deep: bool = True  # takes pictures of 16 bits


# x264's macroblock tree reads uninitialised memory: films of the same pictures would differ.
# Without it they are 3% larger. The conversion centres chroma in 2 by 2 pixels.
X264 = {"crf": "19", "preset": "veryfast", "x264-params": "mbtree=0:chromaloc=1"}
X265 = {"crf": "18", "preset": "fast", "x265-params": "log-level=none:chromaloc=1"}
CODECS = {
    "h264": FilmCodec("libx264", "yuv420p", X264, (".mp4",), deep=False),
    "hevc": FilmCodec("libx265", "yuv420p10le", X265, (".mp4", ".mov"), "hvc1"),
    "prores": FilmCodec(
        "prores_ks", "yuv444p10le", {"profile": "4444", "vendor": "apl0"}, (".mov",), "ap4h",
        "pcm_s16le",
    ),
}  # fmt: skip
"""Constant rate factors are near-transparent: small enough to mail (H.264), or to grade (HEVC)."""
ALPHA_PIXELS = {"prores": "yuva444p10le"}  # of the codecs that hold opacity


def codec_of(out: Path, name: str | None = None) -> str:
    """The name of the codec of a film: the given one, or that of the kind of file; a UserError."""
    suffix = out.suffix.lower()
    fitting = [one for one, codec in CODECS.items() if suffix in codec.containers]
    if name is None:
        return "prores" if suffix == ".mov" else "h264"
    if name not in CODECS:
        raise unknown("codec", name, list(CODECS))
    if name not in fitting:
        wanted = " or ".join(f"FILE{one}" for one in CODECS[name].containers)
        raise UserError(f"cannot hold {name}, expected {wanted}", file=out)
    return name


def box(kind: bytes, content: bytes) -> bytes:
    """Build a box of an MP4 file: length, four letters, content."""
    return struct.pack(">I4s", 8 + len(content), kind) + content


def _st3d(mode: int) -> bytes:
    return box(b"st3d", bytes(4) + bytes([mode]))


def _sv3d() -> bytes:
    header = box(b"svhd", bytes(4) + f"subsea {__version__}".encode() + b"\0")
    pose = box(b"prhd", bytes(4) + struct.pack(">3i", 0, 0, 0))  # front in the middle, level
    whole = box(b"equi", bytes(4) + struct.pack(">4I", 0, 0, 0, 0))  # uncropped
    return box(b"sv3d", header + box(b"proj", pose + whole))


NO_METADATA = VideoMetadata()


def metadata_for(display: str) -> VideoMetadata:
    """Metadata of a film in a display mode."""
    known = {
        "checkerboard": VideoMetadata(packing=0),
        "interlaced": VideoMetadata(packing=2),
        "side-by-side": VideoMetadata(packing=3, boxes=_st3d(2)),
        "top-bottom": VideoMetadata(packing=4, boxes=_st3d(1)),
        "equirectangular": VideoMetadata(boxes=_st3d(0) + _sv3d()),
    }
    return known.get(display, NO_METADATA)


def sa3d() -> bytes:
    """Mark four channels as a sphere of sound of first order ("spatial audio" by Google)."""
    about = struct.pack(">BBIBBI4I", 0, 0, 1, 0, 0, 4, 0, 1, 2, 3)  # ACN, SN3D, in this order
    return box(b"SA3D", about)


# Entries of the sample description, by what they describe.
PICTURES_IN = b"avc1", b"hvc1", b"ap4h"
SOUND_IN = b"mp4a", b"sowt"
# Offset of the boxes inside a box.
CHILDREN_AT = {b"moov": 8, b"trak": 8, b"mdia": 8, b"minf": 8, b"stbl": 8, b"stsd": 16}


def insert_boxes(path: Path, boxes: Mapping[bytes, bytes]) -> None:
    """Append boxes to entries of the sample description of an MP4 file, index first."""
    new = path.with_name(f"{path.name}.tagged")
    try:
        create_part(new)
        with path.open("rb") as source, new.open("wb") as target:
            target.write(_read(source))  # ftyp
            index = _read(source)  # moov
            longer = len(_grown(index, boxes, 0)) - len(index)
            target.write(_grown(index, boxes, longer))
            shutil.copyfileobj(source, target, 1 << 20)
        new.replace(path)
    finally:
        new.unlink(missing_ok=True)


def _read(source: IO[bytes]) -> bytes:
    """Read the next box of a file."""
    head = source.read(8)
    return head + source.read(struct.unpack(">I", head[:4])[0] - 8)


def _grown(whole: bytes, boxes: Mapping[bytes, bytes], shift: int) -> bytes:
    """A copy of a box with `boxes` in entries, and file offsets moved by `shift`."""
    kind = whole[4:8]
    if kind in boxes:
        return box(kind, whole[8:] + boxes[kind])
    if kind in (b"stco", b"co64"):
        number = ">u4" if kind == b"stco" else ">u8"
        offsets = np.frombuffer(whole[16:], number).astype(np.uint64) + np.uint64(shift)
        return whole[:16] + offsets.astype(number).tobytes()
    if kind not in CHILDREN_AT:
        return whole
    start = CHILDREN_AT[kind]
    return box(
        kind, whole[8:start] + b"".join(_grown(b, boxes, shift) for b in _each(whole[start:]))
    )


def _each(data: bytes) -> Iterator[bytes]:
    """Split `data` into its boxes."""
    while data:
        (length,) = struct.unpack(">I", data[:4])
        yield data[:length]
        data = data[length:]


Write = Callable[[int, Pixels], None]  # of a frame (h, w, 3 or 4) by its number
WriteAll = Callable[[int, Mapping[str, Pixels]], None]  # of all windows by name

BITS_S, SPHERE_BITS_S = 96_000, 128_000  # of each channel of sound; of a sphere
TELEVISION = (24, 30, 48, 60, 120)  # nominal rates; broadcasts are 0.1% slower
KINDS = "FILE.mp4, FILE.mov, FILE.png, FILE.exr or a folder's name without a suffix"


def kind_of(out: Path) -> str:
    """The kind of output by its name: "film", "picture" or "folder", else a UserError."""
    kinds = {".mp4": "film", ".mov": "film", ".png": "picture", ".exr": "picture", "": "folder"}
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
        light = LIGHT if out.suffix.lower() == ".exr" else PICTURE
        check_results(files, FILM if kind == "film" else light, force)


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


def frame_file(folder: Path, number: int, suffix: str = ".png") -> Path:
    """Path of a frame in a folder of numbered pictures."""
    return folder / f"frame_{number:05d}{suffix}"


class FilmFormat(NamedTuple):
    """All that a film needs beside its pictures."""

    rate: Fraction
    metadata: VideoMetadata = NO_METADATA
    sound: FilmSound | None = None
    codec: str = "h264"  # one of CODECS
    alpha: bool = False  # pictures have opacity


@contextmanager
def open_writers(
    out: Path, sizes: Mapping[str, tuple[int, int]], film: FilmFormat
) -> Iterator[WriteAll]:
    """Open a writer for pictures of these `sizes` by the names of windows, see `window_path`."""
    with ExitStack() as stack:
        writers = {
            name: stack.enter_context(_open_writer(window_path(out, name), size, film))
            for name, size in sizes.items()
        }

        def write(number: int, pictures: Mapping[str, Pixels]) -> None:
            for name, picture in pictures.items():
                writers[name](number, picture)

        yield write


def _open_writer(
    out: Path, size: tuple[int, int], film: FilmFormat
) -> AbstractContextManager[Write]:
    kind = kind_of(out)
    if kind == "film":
        return film_writer(out, size, film)
    if kind == "picture":
        return nullcontext(lambda number, picture: write_png(out, picture))
    return nullcontext(lambda number, picture: write_png(frame_file(out, number), picture))


# Formats of pictures in memory, by their type and number of components.
IN_MEMORY = {
    (np.dtype(np.uint8), 3): "rgb24",
    (np.dtype(np.uint16), 3): "rgb48le",
    (np.dtype(np.uint8), 4): "rgba",
    (np.dtype(np.uint16), 4): "rgba64le",
}


@contextmanager
def film_writer(out: Path, size: tuple[int, int], film: FilmFormat) -> Iterator[Write]:
    """Write a film, index first. Where colours are halved (yuv420p) the size must be even.

    Colours are converted to BT.709, which players of HD assume, and marked as such.

    An interruption closes the film after the pictures so far; an error leaves no file.
    """
    import av  # here: simulations and windows do not need it
    from av.video.reformatter import Colorspace, VideoReformatter

    interrupted: KeyboardInterrupt | None = None
    codec, sound = CODECS[film.codec], film.sound
    pixels = ALPHA_PIXELS[film.codec] if film.alpha else codec.pixels
    options = dict(codec.options)
    if film.metadata.packing is not None:
        options["x264-params"] += f":frame-packing={film.metadata.packing}"
    frames = 0
    with replacing(out) as temporary:
        with av.open(
            str(temporary), "w", format=out.suffix[1:].lower(), options={"movflags": "+faststart"}
        ) as container:
            stream: Any = container.add_stream(codec.encoder, rate=film.rate, options=options)
            stream.width, stream.height = size
            stream.pix_fmt = pixels
            coder, convert = stream.codec_context, VideoReformatter().reformat
            if codec.tag:
                coder.codec_tag = codec.tag
            # Numbers of ITU-T H.273: matrix and primaries of BT.709, the curve of sRGB.
            coder.colorspace, coder.color_primaries, coder.color_trc = 1, 1, 13
            coder.color_range = 1  # limited
            add_sound = _sound_track(container, sound, codec.sound)

            def write(number: int, picture: Pixels) -> None:
                nonlocal frames
                form = IN_MEMORY[picture.dtype, picture.shape[2]]
                frame = convert(
                    av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format=form),
                    format=pixels, dst_colorspace=Colorspace.ITU709,
                    src_color_range="JPEG", dst_color_range="MPEG",
                )  # fmt: skip
                frame.color_primaries = 1  # ProRes takes it from here
                container.mux(stream.encode(frame))
                frames += 1
                add_sound(float(frames / film.rate))

            try:
                yield write
            except KeyboardInterrupt as interrupt:
                if not frames:
                    raise
                interrupted = interrupt
            container.mux(stream.encode(None))
            add_sound(float(frames / film.rate))
            add_sound(None)
        boxes = dict.fromkeys(PICTURES_IN, film.metadata.boxes) if film.metadata.boxes else {}
        if sound is not None and sound.layout.name == AMBISONIC:
            boxes |= dict.fromkeys(SOUND_IN, sa3d())
        if boxes:
            insert_boxes(temporary, boxes)
    if interrupted:
        raise interrupted


def _sound_track(
    container: Any, sound: FilmSound | None, encoder: str
) -> Callable[[float | None], None]:
    """Add a track of sound; returns a function that fills it up to a time, s, and ends it at None.

    AAC, or samples of 16 bits as they are.
    """
    if sound is None:
        return lambda until: None
    import av

    track: Any = container.add_stream(encoder, rate=RATE, layout=sound.layout.container_name)
    if encoder == "aac":
        each = SPHERE_BITS_S if sound.layout.name == AMBISONIC else BITS_S
        track.bit_rate = each * sound.layout.channels
    read, at = sound.reader(), 0

    def add(until: float | None) -> None:
        nonlocal at
        if until is None:
            container.mux(track.encode(None))
            return
        samples = read(until)
        if len(samples):
            # Interleaved: PyAV counts the planes of eight channels wrongly.
            frame = av.AudioFrame.from_ndarray(
                np.ascontiguousarray(samples, np.float32).reshape(1, -1),
                format="flt", layout=sound.layout.container_name,
            )  # fmt: skip
            frame.sample_rate, frame.pts, frame.time_base = RATE, at, Fraction(1, RATE)
            at += len(samples)
            container.mux(track.encode(frame))

    return add
