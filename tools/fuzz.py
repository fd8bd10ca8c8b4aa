"""Damage every kind of file that the program reads, and check how readers react.

    python tools/fuzz.py [KIND…] [--rounds N] [--seed S] [--keep DIR]

A reader may succeed or raise a UserError of one line. Anything else is a finding: another
exception, a crash, more than SECONDS, more than MEMORY, a file written. The damaged file of a
finding is saved in DIR (default fuzz-findings). Exit code 1 if there is any.
"""

import argparse
import codecs
import gzip
import io
import multiprocessing
import os
import random
import re
import resource
import signal
import sys
import tempfile
import traceback
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import msgspec
import numpy as np
from PIL import ExifTags, Image

from subsea.base.errors import UserError
from subsea.base.files import read_input
from subsea.base.system import resource_path
from subsea.dive.settings import default_text, read_settings
from subsea.export.obj import read_mesh
from subsea.fish import color_sheet
from subsea.fish.measured import load_measured
from subsea.fish.outline_file import read_outline
from subsea.fish.species import Species, load_species
from subsea.lab.benchmark_reports import read_reports
from subsea.lab.run_store import RunResult, read_results, read_run_file, result_line
from subsea.lab.simulate import simulate
from subsea.media.record import read_record
from subsea.repertoire import read_repertoire
from subsea.scenario.load import load_scenario
from subsea.scenario.storage import read_thumbnail
from subsea.stage.calibration.points import read_points
from subsea.stage.cluster import messages
from subsea.stage.show_file import load_show
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.mesh_formats import read_warp as read_any_warp
from subsea.stage.theatre.mpcdi import read_mpcdi
from subsea.stage.theatre.pixel_files import parse_pfm
from subsea.studio.dress import load_mesh, save_mesh
from subsea.studio.photograph import Photograph, read_photograph
from subsea.studio.side_view import centred_matrix, make_fish_meshes
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.world import World
from tests.support import theatre_samples as theatres

TEXT = (".toml", ".json", ".obj", ".csv", ".simcad", ".ol", ".skyskan", ".ndisplay")
SECONDS = 10  # for one file
KILL_AFTER = 6  # times SECONDS, then the process is killed
MEMORY = 2 * 2**30  # bytes
RUN = "c0ffee"  # inputs of a run of a sweep
MAX_FINDINGS = 5  # of a kind, then the next kind
FILE_EVENTS = {"os.remove", "os.rename", "os.mkdir", "os.rmdir", "subprocess.Popen", "os.system"}
WRITE_MODES = re.compile(r"[wax+]")
EXTREME_VALUES = [
    *(b"nan", b"inf", b"-1", b"0", b"1e308", b"9" * 40, b"9" * 5000, b"1e400"),
    *(b"1979-05-27", b'"text"', b"[]", b"{}", b"true", b"1.5"),
]
ODD_LINES = [
    *(b'nonsense = "\\u0000"\n', b"[a.b.c]\n", b"\xff\xfe\n", b'"two\\nlines" = 1\n'),
    *(b'x = "' + b"a" * 100_000 + b'"\n', b"k" * 100_000 + b" = 1\n"),
    *(b"a." * 20_000 + b"a = 1\n", b"x = " + b"{a=" * 50_000 + b"\n"),
]
FORK = multiprocessing.get_context("fork")


class Kind(NamedTuple):
    """A kind of file, with samples and a reader."""

    suffix: str
    samples: Callable[[Path], list[bytes]]  # sound files; may write to the given folder
    read: Callable[[Path], object]


def shipped(folder: str, suffix: str) -> Callable[[Path], list[bytes]]:
    """Take the shipped files in a folder."""
    paths = sorted(resource_path(folder).glob(f"*{suffix}"))
    return lambda unused: [path.read_bytes() for path in paths]


def read_once(sample: bytes, path: Path, read: Callable[[Path], object]) -> list[bytes]:
    """Read a sample, so that kernels are compiled."""
    path.write_bytes(sample)
    read(path)
    return [sample]


@cache
def small_sea() -> World:
    """Make a world of five fishes."""
    return create_world(load_scenario("preying")[0], fish=5)


@cache
def clownfish() -> tuple[Species, Photograph]:
    """Load a species, and make the picture of one."""
    photograph = Photograph(Path("fish.png"), np.zeros((120, 160, 3), np.uint8), None)
    return load_species("clownfish"), photograph


def skin_meshes(folder: Path) -> list[bytes]:
    """Make meshes over a photograph."""
    species, photograph = clownfish()
    meshes = make_fish_meshes(species.surface, centred_matrix(160, 120, species.surface))
    save_mesh(folder / "mesh.json", photograph, meshes)
    return [(folder / "mesh.json").read_bytes()]


def read_skin_meshes(path: Path) -> object:
    """Read meshes as `--mesh` does."""
    species, photograph = clownfish()
    return load_mesh(path, photograph, species)


def records(folder: Path) -> list[bytes]:
    """Make a short record of a simulation."""
    path = folder / "sample.h5"
    simulate(4, path, "preying", 5, 1)
    return [path.read_bytes()]


def runs(unused: Path) -> list[bytes]:
    """Make the result of a run of a sweep."""
    return [
        msgspec.json.encode({"inputs": RUN, "measures": {"seconds": 1.5, "mating.share": None}})
    ]


def journals(unused: Path) -> list[bytes]:
    """Make the results of some runs of a sweep."""
    return [b"".join(result_line(RunResult(f"run{k}", RUN, {"seconds": k})) for k in range(3))]


def reports(unused: Path) -> list[bytes]:
    """Make reports of a benchmark."""
    report = {
        "fish": 60, "version": "0.2.0", "frame_ms": {"p50": 2.0}, "stages_ms": {"draw": 1.0},
        "renderer": "any", "size": [640, 480], "display": "mono", "scenario": "peaceful",
        "seed": 1, "frames": 10, "without": [], "parts_ms": {"draw": [1.0, 2.0]},
    }  # fmt: skip
    return [msgspec.json.encode(report), msgspec.json.encode({"ladder": [report, report]})]


def float_maps(unused: Path) -> list[bytes]:
    """Make a portable float map."""
    return [b"PF\n6 4\n-1.0\n" + np.ones((4, 6, 3), np.float32).tobytes()]


def archives(folder: Path) -> list[bytes]:
    """Make a projector of a calibration program."""
    return read_once(theatres.mpcdi(), folder / "sample.mpcdi", read_mpcdi)


def squares(folder: Path) -> list[bytes]:
    """Make a mesh of four corners."""
    corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    faces = "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
    return read_once(f"{corners}{faces}".encode(), folder / "sample.obj", read_warp)


def warp_kind(suffix: str, *samples: bytes) -> Kind:
    """Describe the meshes of another calibration program."""
    return Kind(
        suffix,
        lambda folder: [
            read
            for sample in samples
            for read in read_once(sample, folder / f"sample{suffix}", read_warp)
        ],
        read_warp,
    )


def configurations(folder: Path) -> list[bytes]:
    """Make SGCT configurations with every projection, and the meshes that they name."""
    (folder / "mesh.sgc").write_bytes(theatres.sgc())
    for face in ("bottom", "left", "right", "top"):
        (folder / f"{face}.obj").write_bytes(squares(folder)[0])
    (folder / "mesh.pfm").write_bytes(float_maps(folder)[0])
    views = theatres.viewports()
    return [theatres.text(theatres.sgct(chosen)) for chosen in (*([view] for view in views), views)]


def read_theatre(path: Path) -> object:
    """Read the channels of a theatre, and an error for each faulty one."""
    theatre, source = load_theatre(str(path))
    return usable_channels(theatre, source)


def read_warp(path: Path) -> object:
    """Read a warp for a small projector."""
    return read_any_warp(path, (64, 48))


def read_float_map(path: Path) -> object:
    """Read the numbers of a float map."""
    return parse_pfm(read_input(path), str(path))


def node_messages(unused: Path) -> list[bytes]:
    """Make messages of nodes of a cluster."""
    who = messages.Identity("0.2.0", {"scenario": "A bay", "seed": "1", "subsea/fish": "#0f"})
    sent = [messages.Hello("left", who), messages.PictureDrawn(7), messages.Diverged(40)]
    return [messages.encode(message) for message in (*sent, messages.StatePart(40, 20, bytes(20)))]


def master_messages(unused: Path) -> list[bytes]:
    """Make messages of the master of a cluster."""
    picture = messages.Picture(7, 40, 0.5, [(0.1, -0.2, 0.3, 0.0, False)], [(*(1.0,) * 8, True)])
    state = messages.WorldState("d", 7, bytes(40))
    sent = [state, picture, messages.Swap(7), messages.Refused("no"), messages.Resume(9)]
    return [messages.encode(message) for message in (*sent, messages.OpenSea("two", 3))]


def photographs(folder: Path) -> list[bytes]:
    """Make pictures of cameras and paint programs in several formats."""
    noise = Image.effect_noise((160, 120), 60.0)
    turned = Image.Exif()
    turned[ExifTags.Base.Orientation] = 6
    fine = Image.fromarray(np.arange(160 * 120, dtype=np.uint16).reshape(120, 160))
    modes = {"JPEG": "RGB", "PNG": "RGBA", "TIFF": "CMYK", "WEBP": "RGB", "GIF": "P"}
    pictures = [(noise, "JPEG", {"exif": turned}), (fine, "PNG", {})]
    pictures += [(noise.convert("RGB").convert(mode), name, {}) for name, mode in modes.items()]
    samples = []
    for picture, name, more in pictures:
        packed = io.BytesIO()
        picture.save(packed, name, **more)
        samples.append(packed.getvalue())
    return samples


def sheets(folder: Path) -> list[bytes]:
    """Make the texture of a species."""
    color_sheet.write(folder / "sheet.png", np.zeros((640, 1024, 4), np.uint8))
    return [(folder / "sheet.png").read_bytes()]


POINTS = b"".join(
    b'[[point]]\nname = "mark"\nat_cm = [%d, 0, 300.5]\npixel = [%d, 20]\n' % (x, x + 100)
    for x in range(-60, 61, 20)
)
SHOW = b"""title = "a show"
fade_s = 2
[hours]
monday = "10:00-17:30"
friday = ["10:00-12:00", "18:00-02:00"]
[[special_day]]
title = "Gala"
yearly = "12-24"
days = 3
hours = "closed"
[[special_day]]
date = 2026-12-31
[osc]
address = "127.0.0.1:9000"
[timecode]
source = "ltc"
rate = 29.97
[midi]
port = "keys"
[[midi.cue]]
note = 60
command = "item 2"
[[item]]
scenario = "peaceful"
tour = "reef"
for_s = 60
osc = ["/cue/1/fire 2.5"]
[[item]]
start = "10:30"
caption = { de = "halb elf", en = "half past ten" }
[[item]]
start = "01:00:00:00"
days = ["sunday", "Gala"]
scenario = "schooling"
overlay = { file = "title.png", tilt_deg = 20 }
[[item]]
start = "cue"
scenario = "some/sea.toml"
"""

LAMPS = b"""
[lights]
protocol = "artnet"
address = "127.0.0.1"
[[lamp]]
name = "one"
channel = 1
azimuth_deg = 90
[[lamp]]
name = "two"
channel = 510
universe = 3
colours = "white"
"""

KINDS = {
    "repertoire": Kind(".h5", shipped("repertoires", ".h5"), read_repertoire),
    "record": Kind(".h5", records, read_record),
    "scenario": Kind(
        ".toml", shipped("assets/scenarios", ".toml"), lambda p: load_scenario(str(p))
    ),
    "thumbnail": Kind(
        ".jpg",
        shipped("assets/scenarios", ".jpg"),
        lambda p: read_thumbnail(p.with_suffix(".toml")),
    ),
    "species": Kind(".toml", shipped("assets/species", ".toml"), lambda p: load_species(str(p))),
    "outline": Kind(
        ".toml", shipped("docs/outlines", ".toml"), lambda p: read_outline(p, None, None)
    ),
    "measured": Kind(
        ".toml", lambda unused: [resource_path("assets/swimming.toml").read_bytes()], load_measured
    ),
    "theatre": Kind(
        ".toml",
        lambda folder: [one + LAMPS for one in shipped("assets/theatres", ".toml")(folder)],
        lambda p: load_theatre(str(p)),
    ),
    "points": Kind(".toml", lambda unused: [POINTS], lambda p: read_points(p, np.zeros(3), [])),
    "show": Kind(".toml", lambda unused: [SHOW], load_show),
    "settings": Kind(".toml", lambda unused: [default_text().encode()], read_settings),
    "snapshot": Kind(
        ".bin",
        lambda unused: [snapshot.take(small_sea())],
        lambda p: snapshot.restore(small_sea(), p.read_bytes()),
    ),
    "from-node": Kind(".bin", node_messages, lambda p: messages.from_node(p.read_bytes())),
    "from-master": Kind(".bin", master_messages, lambda p: messages.from_master(p.read_bytes())),
    "report": Kind(".json", reports, read_reports),
    "run": Kind(".json", runs, lambda p: read_run_file(p, RUN)),
    "journal": Kind(".jsonl", journals, read_results),
    "shard": Kind(".gz", lambda unused: [gzip.compress(journals(unused)[0])], read_results),
    "photograph": Kind(".png", photographs, read_photograph),
    "sheet": Kind(".png", sheets, color_sheet.read),
    "meshes": Kind(".json", skin_meshes, read_skin_meshes),
    "float-map": Kind(".pfm", float_maps, read_float_map),
    "archive": Kind(".mpcdi", archives, read_mpcdi),
    "warp": Kind(".obj", squares, read_warp),
    "mesh": Kind(".obj", squares, read_mesh),
    "sgct": Kind(".json", configurations, read_theatre),
    "ndisplay": Kind(
        ".ndisplay", lambda unused: [theatres.text(theatres.ndisplay())], read_theatre
    ),
    "sciss": warp_kind(".sgc", theatres.sgc(1), theatres.sgc(2), theatres.sgc(2, False)),
    "domeprojection": warp_kind(".csv", theatres.csv()),
    "simcad": warp_kind(".simcad", theatres.simcad()),
    "scalable": warp_kind(".ol", theatres.ol(), theatres.ol(99)),
    "skyskan": warp_kind(".skyskan", theatres.skyskan()),
    "vioso": warp_kind(".vwf", theatres.vwf(2), theatres.vwf(bits=64)),
}


# Damage


def damage(sample: bytes, suffix: str, rng: random.Random) -> bytes:
    """Damage a sample by one to four accidents typical of its kind."""
    accidents = [truncate, flip_bits, zero_range]
    if suffix in TEXT:
        accidents += [*3 * [replace_number], *3 * [damage_lines], nest_brackets, save_elsewhere]
    if suffix == ".h5":
        accidents += 3 * [corrupt_hdf5]
    if suffix == ".mpcdi":
        accidents += 5 * [corrupt_zip]
    if suffix == ".bin":
        accidents += [nest_messagepack]
    for _ in range(rng.randint(1, 4)):
        sample = rng.choice(accidents)(sample, rng)
    return sample


def truncate(data: bytes, rng: random.Random) -> bytes:
    """Cut off the end."""
    return data[: rng.randrange(len(data) + 1)]


def flip_bits(data: bytes, rng: random.Random) -> bytes:
    """Flip some bits."""
    made = bytearray(data)
    for _ in range(rng.randint(1, 20) if made else 0):
        made[rng.randrange(len(made))] ^= 1 << rng.randrange(8)
    return bytes(made)


def zero_range(data: bytes, rng: random.Random) -> bytes:
    """Overwrite a range with zeros."""
    begin = rng.randrange(len(data) + 1)
    long = min(rng.choice([1, 8, 512, 4096]), len(data) - begin)
    return data[:begin] + bytes(long) + data[begin + long :]


def replace_number(data: bytes, rng: random.Random) -> bytes:
    """Replace a number by an extreme value."""
    numbers = list(re.finditer(rb"-?\d+\.?\d*", data))
    if not numbers:
        return data
    one = rng.choice(numbers)
    return data[: one.start()] + rng.choice(EXTREME_VALUES) + data[one.end() :]


def damage_lines(data: bytes, rng: random.Random) -> bytes:
    """Delete a line, repeat it elsewhere, or insert an odd one."""
    lines = data.splitlines(keepends=True) or [b""]
    chosen = rng.randrange(len(lines))
    match rng.randrange(3):
        case 0:
            del lines[chosen]
        case 1:
            lines.insert(chosen, rng.choice(lines))
        case _:
            lines.insert(rng.randint(0, len(lines)), rng.choice(ODD_LINES))
    return b"".join(lines)


def save_elsewhere(data: bytes, rng: random.Random) -> bytes:
    """Save a text as the editor of another system does."""
    text = data.decode("latin-1")
    continued = text.replace(" ", " \\\n", rng.randrange(1, 4))
    ways = [
        codecs.BOM_UTF8 + data,
        codecs.BOM_UTF16_LE + text.encode("utf-16-le")[: None if rng.random() < 0.8 else -1],
        codecs.BOM_UTF16_BE + text.encode("utf-16-be"),
        b"# \xe9\x85\xa0\n" + data,
        data.replace(b"\n", rng.choice([b"\r\n", b"\r"])),
        continued.encode("latin-1"),
    ]
    return rng.choice(ways)


def nest_brackets(data: bytes, rng: random.Random) -> bytes:
    """Append nested brackets."""
    deep = rng.choice([5, 500, 50_000])
    return data + b"\nx = " + b"[" * deep + b"]" * rng.choice([0, deep]) + b"\n"


def nest_messagepack(data: bytes, rng: random.Random) -> bytes:
    """Append nested MessagePack tables after the head of a message."""
    begin = rng.choice([0, len(messages.MAGIC)])
    return data[:begin] + rng.choice([b"\x91", b"\x81\xa1x", b"\x81\xa4type"]) * 1300


def corrupt_hdf5(data: bytes, rng: random.Random) -> bytes:
    """Corrupt objects of an HDF5 file; unreadable files are not changed."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "file.h5"
        path.write_bytes(data)
        # With this library even writing to a damaged file may crash.
        other = random.Random(rng.getrandbits(64))
        maker = FORK.Process(target=_corrupt_in_process, args=(path, other))
        maker.start()
        maker.join(SECONDS)
        maker.kill()
        maker.join()
        return data if maker.exitcode else path.read_bytes()


def _corrupt_in_process(path: Path, rng: random.Random) -> None:
    try:
        with _record_unraisable(), h5py.File(path, "r+", locking=False) as file:
            names: list[str] = []
            file.visit(names.append)
            if names:
                _corrupt_object(file, rng.choice(names), rng)
    except Exception:  # the file is damaged already
        os._exit(1)
    os._exit(0)


def zip_bomb() -> bytes:
    """2.5 MB that deflate to more than the available memory."""
    packing = zlib.compressobj(9)
    parts = [packing.compress(bytes(2**22)) + packing.flush(zlib.Z_FULL_FLUSH) for _ in range(2)]
    return parts[0] + parts[1] * (MEMORY // 2**22 + 128)


def corrupt_zip(data: bytes, rng: random.Random) -> bytes:
    """Damage or move one file in a zip archive."""
    packed = io.BytesIO()
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as before, zipfile.ZipFile(packed, "w") as after:
            chosen = rng.choice(before.namelist())
            for name in before.namelist():
                content = before.read(name)
                if name == chosen:
                    suffix = ".toml" if name.endswith(".xml") else Path(name).suffix
                    content = damage(content, suffix, rng)
                    name = rng.choice([name, name, name, f"../../{name}", f"/etc/{name}"])
                method = rng.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
                after.writestr(name, content, method)
    except Exception:  # the archive is damaged already
        return data
    return packed.getvalue()


def _corrupt_object(file: Any, name: str, rng: random.Random) -> None:
    """Corrupt one object of a file."""
    here = file[name]
    shape = getattr(here, "shape", None) or (3,)
    way = rng.randrange(14)
    if way == 0 and here.attrs:
        key = rng.choice(list(here.attrs))
        here.attrs[key] = rng.choice([np.nan, -1, "text", np.zeros(3), np.bytes_(b"\xff"), 1e300])
        return
    if way == 1 and isinstance(here, h5py.Dataset) and here.dtype.kind == "f" and here.size:
        here[...] = rng.choice([np.nan, np.inf, 1e30])
        return
    del file[name]
    if way == 2:
        file[name] = h5py.ExternalLink("/etc/passwd", "/")
    elif way == 3:
        file[name] = h5py.SoftLink(f"/{name}")
    elif way == 4:
        file.create_dataset(name, (2**40,), "f8", chunks=(1024,))
    elif way == 5:
        file.create_dataset(name, (3,), h5py.ref_dtype)
    elif way == 6:
        file.create_dataset(name, (3,), h5py.string_dtype())
    elif way == 7:
        file.create_group(name)
    elif way == 8:  # a cycle
        file[name] = file["/"]
    elif way == 9:  # a virtual dataset
        source = rng.choice(["/etc/passwd", "."])
        layout = h5py.VirtualLayout(shape, "f8")
        layout[...] = h5py.VirtualSource(source, name, shape)
        file.create_virtual_dataset(name, layout)
    elif way == 10:  # a chunk much larger than the data
        huge = (2**16, 2**13, *shape[2:])[: len(shape)]
        file.create_dataset(
            name, shape, "f8", maxshape=(None,) * len(shape), chunks=huge, compression="gzip"
        )
    elif way == 11:  # a chunk that unpacks to far more
        made = file.create_dataset(name, shape, "f4", chunks=shape, compression="gzip")
        made.id.write_direct_chunk((0,) * len(shape), zip_bomb())
    elif way == 12:
        file.create_dataset(name, shape, h5py.enum_dtype({"a": 1}))
    else:
        file.create_dataset(name, shape, rng.choice(["f2", "i8", "c16", "S7", "f4,i2"]))


# Observation


def fuzz(name: str, kind: Kind, rounds: int, seed: int, keep: Path) -> int:
    """Read `rounds` damaged files in a separate process; print and count the findings."""
    begin, findings = 0, 0
    while begin < rounds and findings < MAX_FINDINGS:
        with tempfile.TemporaryDirectory() as folder:
            mine, theirs = multiprocessing.Pipe(duplex=False)
            worker = FORK.Process(
                target=_read_damaged, args=(kind, range(begin, rounds), seed, Path(folder), theirs)
            )
            worker.start()
            theirs.close()
            number, what = begin, None
            try:
                mine.recv()  # samples may take long: kernels are compiled
                while what is None and mine.poll(KILL_AFTER * SECONDS):
                    number, what = mine.recv()
            except EOFError:
                pass
            else:
                if what is None:
                    worker.kill()
            worker.join()
            if worker.exitcode:
                what = f"the process ended with {worker.exitcode}"
            if what:
                findings += 1
                keep.mkdir(parents=True, exist_ok=True)
                saved = keep / f"{name}-{seed}-{number}{kind.suffix}"
                saved.write_bytes((Path(folder) / f"damaged{kind.suffix}").read_bytes())
                print(f"{name}, round {number}: {what}\n    {saved}")
            begin = number + 1 if what else rounds
    print(f"{name}: {rounds} damaged files, {findings} findings", flush=True)
    return findings


def _read_damaged(kind: Kind, rounds: range, seed: int, folder: Path, pipe: Any) -> None:
    """Read files one after another; send the number of each before, and its finding after."""
    samples = kind.samples(folder)
    path = folder / f"damaged{kind.suffix}"
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, -1))
    pipe.send("ready")
    for number in rounds:
        rng = random.Random(f"{seed} {number}")
        path.write_bytes(damage(rng.choice(samples), kind.suffix, rng))
        pipe.send((number, None))
        what = finding(kind.read, path)
        if what:
            pipe.send((number, what))
            return


def finding(read: Callable[[Path], object], path: Path) -> str | None:
    """The finding about how a reader treats a file; None if correct."""
    try:
        with _record_writes() as written, _time_limit(), _record_unraisable() as ignored:
            read(path)
    except UserError as refused:
        if len(str(refused).splitlines()) != 1:
            return f"not one line: {str(refused)[:300]!r}"
    except BaseException:
        return traceback.format_exc(limit=-4)
    if ignored:
        return f"unraisable exception: {ignored[0]}"
    return f"written: {', '.join(written)}" if written else None


_written: list[str] | None = None


def _audit(event: str, arguments: tuple[Any, ...]) -> None:
    if _written is None:
        return
    if event == "open" and isinstance(arguments[1], str) and WRITE_MODES.search(arguments[1]):
        _written.append(str(arguments[0]))
    elif event in FILE_EVENTS:
        _written.append(f"{event} {arguments[0]}")


sys.addaudithook(_audit)


@contextmanager
def _record_writes() -> Iterator[list[str]]:
    """List the files opened for writing, moved or removed inside."""
    global _written
    _written = found = []
    try:
        yield found
    finally:
        _written = None


@contextmanager
def _record_unraisable() -> Iterator[list[str]]:
    """List the exceptions inside that cannot be raised, as in destructors."""
    found: list[str] = []
    before, sys.unraisablehook = sys.unraisablehook, lambda one: found.append(str(one.exc_value))
    try:
        yield found
    finally:
        sys.unraisablehook = before


@contextmanager
def _time_limit() -> Iterator[None]:
    """Raise TimeoutError after SECONDS, as soon as a library returns to Python."""

    def late(*unused: object) -> None:
        raise TimeoutError(f"not done after {SECONDS} s")

    signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)


def main() -> int:
    """Run from the command line; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("kinds", metavar="KIND", nargs="*", help=f"of {', '.join(KINDS)} (all)")
    parser.add_argument("--rounds", type=int, default=1000, help="of each kind (1000)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, default=Path("fuzz-findings"), metavar="DIR")
    options = parser.parse_args()
    if wrong := {*options.kinds} - {*KINDS}:
        parser.error(f"unknown kind {min(wrong)!r}; there are: {', '.join(KINDS)}")
    kinds = options.kinds or [*KINDS]
    found = [fuzz(kind, KINDS[kind], options.rounds, options.seed, options.keep) for kind in kinds]
    return 1 if any(found) else 0


if __name__ == "__main__":
    sys.exit(main())
