"""Measure exported files: bytes and errors of each format and compression, as tables.

.venv/bin/python tools/measure_export.py [--detail N] [SPECIES ...]

Errors are distances of vertices from playback, in percent of the body length, over all frames of
all segments: root mean square, and the largest. Files are read again by the reader of the tests.
"""

import argparse
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import meshopt
import numpy as np

from subsea.export import COMPRESSIONS
from subsea.export.clips import Clip, Model, all_points, make_clips, transform_points
from subsea.export.conventions import METRES, Y_UP, Z_UP, to_metres
from subsea.export.glb import packing_of
from subsea.export.gltf import write_gltf
from subsea.export.skinning import Skeleton, fit_skeleton
from subsea.export.usd import write_usd
from subsea.export.vat import encode, write_vat
from subsea.fish.species import shipped_species
from tests.support.gltf_reader import Reader

EVERY = 4  # of the clips with morph targets are read


def opened(file: Path) -> Reader:
    """Open a file with its compressed arrays."""
    reader = Reader(file)
    buffers = reader.content["buffers"]
    whole = bytearray(buffers[1]["byteLength"] if len(buffers) > 1 else 0)
    for view in reader.content["bufferViews"]:
        packed = view.get("extensions", {}).get("EXT_meshopt_compression")
        if packed:
            data = reader.binary[packed["byteOffset"] :][: packed["byteLength"]]
            out = meshopt.decode_gltf_buffer(
                data, packed["count"], packed["byteStride"], packed["mode"], packed.get("filter")
            ).tobytes()
            whole[view["byteOffset"] : view["byteOffset"] + len(out)] = out
    reader.unpacked = bytes(whole)
    return reader


def errors(file: Path, model: Model, clips: list[Clip]) -> tuple[float, float]:
    """Compute the root mean square and largest error of a glTF file."""
    reader = opened(file)
    square, most, count = 0.0, 0.0, 0
    for clip in clips:
        points = transform_points(clip.points, clip.position, clip.rotation)
        found = reader.points(clip.name, reader.times(clip.name))
        off = np.linalg.norm(found - to_metres(points, Y_UP), axis=2) * 100.0
        off /= METRES * model.length_cm
        square, most, count = square + (off**2).sum(), max(most, off.max()), count + off.size
    return float(np.sqrt(square / count)), float(most)


def texture_errors(model: Model, clips: list[Clip]) -> tuple[float, float]:
    """Compute both errors of a vertex animation texture."""
    texture = encode(model, clips, False)
    share = texture.texels[: len(texture.texels) // 2] / 65535.0
    ways = texture.low + share * (texture.high - texture.low)
    goal = to_metres(np.concatenate([clip.points for clip in clips]) - model.rest, Z_UP)
    off = np.linalg.norm(ways - goal, axis=2) * 100.0 / (METRES * model.length_cm)
    return float(np.sqrt((off**2).mean())), float(off.max())


def size(files: list[Path]) -> str:
    """Add up the megabytes of files."""
    return f"{sum(file.stat().st_size for file in files) / 1e6:.1f} MB"


def skeleton_row(folder: Path, model: Model, clips: list[Clip], rig: Skeleton) -> str:
    """Make a row of the table of skeletons."""
    cells = [f"{len(rig.joints)}", f"{sum(len(clip.points) for clip in clips)}"]
    for kind in COMPRESSIONS:
        file = write_gltf(folder, model, clips, False, rig, packing_of(kind))
        rms, most = errors(file, model, clips)
        cells += [size([file]), f"{rms:.2f}% ({most:.1f}%)"]
    return " | ".join([f"| {model.name.replace('_', ' ')}", *cells]) + " |"


def exact_row(folder: Path, model: Model, clips: list[Clip]) -> str:
    """Make a row of the table of exact formats."""
    cells = []
    for kind in COMPRESSIONS:
        file = write_gltf(folder, model, clips, False, None, packing_of(kind))
        _, most = errors(file, model, clips[::EVERY])
        cells += [size([file]), f"{most:.4f}%"]
    _, most = texture_errors(model, clips)
    cells += [size(write_vat(folder, model, clips, False)), f"{most:.4f}%"]
    cells.append(size(write_usd(folder, model, clips, False)))
    return " | ".join([f"| {model.name.replace('_', ' ')}", *cells]) + " |"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("species", nargs="*", default=shipped_species())
    parser.add_argument("--detail", type=int, choices=range(4), default=0)
    options = parser.parse_args()
    skeletons, exact = [], []
    for name in options.species:
        model, clips = make_clips(name, options.detail)
        with TemporaryDirectory() as folder:
            exact.append(exact_row(Path(folder), model, clips))
            print(exact[-1], file=sys.stderr, flush=True)
            rig = fit_skeleton(model, all_points(clips))
            skeletons.append(skeleton_row(Path(folder), model, clips, rig))
            print(skeletons[-1], file=sys.stderr, flush=True)
    kinds = [f"{kind} | off" for kind in COMPRESSIONS]
    print(" | ".join(["|", "joints", "frames", *kinds]) + " |")
    print("| --- " * 9 + "|")
    print("\n".join(skeletons))
    print()
    print(" | ".join(["|", *kinds, "vat | off", "usd"]) + " |")
    print("| --- " * 10 + "|")
    print("\n".join(exact))


if __name__ == "__main__":
    main()
