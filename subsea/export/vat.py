"""Encode vertex animation textures in the OpenVAT layout, and write those of a species.

OpenVAT (https://github.com/sharpen3d/openvat, README and `Development/openvat/`, version 1.1.2) is
an encoder for Blender with decoders for several engines. With its standard settings (normals
packed, single row, PNG16) it writes a folder NAME_vat with

- NAME_vat.png, 16 bits: column i is a vertex, row f of the upper half frame f of all clips. Red,
  green and blue are the offset of the vertex from rest along x, y and z of Blender, from Min to
  Max. The lower half has the normals, from -1 to 1.
- NAME.glb: the mesh at rest. Its second texture coordinates are the centre of a vertex's texel in
  frame 0; frame f is f / height lower, normals half of the height.
- NAME-remap_info.json: Min, Max and Frames as `os-remap`, and the clips as `animations`, whose
  frames count from 1 and include the last.

We add the colour texture, and more data as `subsea` in the JSON.

`gltf_scene.py` writes textures of the fishes of a scene in this layout.
"""

import json
import struct
import zlib
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.base.file_kinds import json_file
from subsea.base.files import replacing
from subsea.export.clips import Clip, Model, bake_root, first_frames
from subsea.export.conventions import METRES, Y_UP, Z_UP, rotate_quaternions, sheet_png, to_metres
from subsea.export.glb import CLAMPED, EXACT, INDICES, VERTICES, GlbBuffer, asset, glb, material
from subsea.export.gltf import add_vertices
from subsea.export.skin_material import roughness

FULL = 65535  # the greatest value of a texel
ALPHA_CUTOFF = 0.3  # of the only material, for body and fins
REMAP = json_file("a description of an OpenVAT texture", "os-remap")


class AnimationTexture(NamedTuple):
    """A vertex animation texture of n vertices and F frames."""

    texels: NDArray[np.uint16]  # (2F, n, 3): offsets from rest, then normals
    low: Array  # (3,) metres, Blender's axes: offset of value 0 ...
    high: Array  # ... and of FULL


def vat_files(folder: Path, name: str) -> list[Path]:
    """Return the files that `write_vat` writes: animation texture, colours, mesh and ranges."""
    names = f"{name}_vat.png", f"{name}_basecolor.png", f"{name}.glb", f"{name}-remap_info.json"
    return [folder / f"{name}_vat" / file for file in names]


def write_vat(folder: Path, model: Model, clips: list[Clip], baked: bool) -> list[Path]:
    """Write the folder NAME_vat into `folder`; return the files.

    The motion of the root is in the JSON, or `baked` into the texture. UserError if a file cannot
    be written.
    """
    texture = encode(model, clips, baked)
    files = vat_files(folder, model.name)
    contents = (
        png16(texture.texels),
        sheet_png(model.sheet),
        _mesh(model, len(texture.texels), files[1].name),
        _ranges(model, clips, texture, baked),
    )
    with ExitStack() as all_or_none:
        for path, data in zip(files, contents, strict=True):
            all_or_none.enter_context(replacing(path)).write_bytes(data)
    return files


def encode(model: Model, clips: list[Clip], baked: bool) -> AnimationTexture:
    """Encode all clips, which follow each other."""
    if baked:
        clips = [bake_root(clip) for clip in clips]
    points, normals = (
        np.concatenate(part)
        for part in zip(*((clip.points, clip.normals) for clip in clips), strict=True)
    )
    return encode_points(model, points, normals)


def encode_points(model: Model, points: Array, normals: Array) -> AnimationTexture:
    """Encode points, cm, body axes, and normals (F, n, 3)."""
    offsets = to_metres(points - model.rest, Z_UP)
    low, high = offsets.min(axis=(0, 1)), offsets.max(axis=(0, 1))
    share = (offsets - low) / np.where(high > low, high - low, 1.0)
    facing = 0.5 + 0.5 * (normals @ Z_UP.T)
    texels = np.round(FULL * np.clip(np.concatenate([share, facing]), 0.0, 1.0)).astype(np.uint16)
    return AnimationTexture(texels, low, high)


def texel_coordinates(count: int, height: int) -> Array:
    """Compute texture coordinates (count, 2) of frame 0, from the upper left corner."""
    across = (np.arange(count) + 0.5) / count
    return np.stack([across, np.full(count, 0.5 / height)], axis=1)


def _mesh(model: Model, height: int, colours: str) -> bytes:
    """Make the mesh at rest as .glb, with texture coordinates of the animation texture."""
    buffer = GlbBuffer(EXACT)
    plain = model._replace(scales=None)  # a vertex shader would have to turn tangents, too
    attributes = add_vertices(buffer, plain, EXACT.grid(to_metres(model.rest, Y_UP)))
    texels = texel_coordinates(len(model.rest), height).astype(np.float32)
    attributes["TEXCOORD_1"] = buffer.add(texels, VERTICES)
    primitive = {
        "attributes": attributes,
        "indices": buffer.add(model.triangles.astype(np.uint16).ravel(), INDICES),
        "material": 0,
    }
    looks = {"alphaMode": "MASK", "alphaCutoff": ALPHA_CUTOFF, "doubleSided": True}
    content = {
        "asset": asset([model.name], {}),
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": model.name, "mesh": 0}],
        "meshes": [{"name": model.name, "primitives": [primitive]}],
        "materials": [material(model.name, looks, roughness(model))],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": CLAMPED, "wrapT": CLAMPED}],
        "images": [{"uri": quote(colours)}],
    }
    return glb(content, buffer)


def _ranges(model: Model, clips: list[Clip], texture: AnimationTexture, baked: bool) -> bytes:
    """Describe the clips of a species in JSON."""
    extras: dict[str, Any] = {
        "bodyLength": METRES * model.length_cm,
        "framesPerSecond": float(clips[0].fps),
    }
    if not baked:
        extras["root"] = {
            clip.name: {
                "position": np.round(to_metres(clip.position, Z_UP), 9).tolist(),
                "rotation": np.round(rotate_quaternions(clip.rotation, Z_UP), 9).tolist(),
            }
            for clip in clips
        }
    tracks = {
        clip.name: animation_track(first, len(clip.points), clip.fps, clip.cyclic)
        for clip, first in zip(clips, first_frames(clips), strict=True)
    }
    return remap_info(texture, tracks, extras)


def animation_track(first: int, count: int, fps: float, looping: bool) -> dict[str, Any]:
    """Describe an animation of `count` frames from the row `first` on."""
    return {
        "startFrame": first + 1,
        "endFrame": first + count,
        "framerate": round(fps),
        "looping": looping,
    }


def remap_info(
    texture: AnimationTexture, tracks: dict[str, dict[str, Any]], extras: dict[str, Any]
) -> bytes:
    """Encode the JSON of a texture: the keys of OpenVAT, then our own."""
    content = {
        "os-remap": {
            "Min": texture.low.tolist(),
            "Max": texture.high.tolist(),
            "Frames": len(texture.texels) // 2,
        },
        "animations": tracks,
        "subsea": extras,
    }
    return (json.dumps(content, indent=1) + "\n").encode()


def png16(texels: NDArray[np.uint16]) -> bytes:
    """Encode texels (h, w, 3), top row first, with 16 bits a channel (not in Pillow)."""
    height, width, _ = texels.shape
    rows = texels.astype(">u2").view(np.uint8).reshape(height, -1)
    # Filter 2 stores differences from the row above: frames are similar.
    rows[1:] -= rows[:-1].copy()
    lines = np.concatenate([np.full((height, 1), 2, np.uint8), rows], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 16, 2, 0, 0, 0)
    chunks = (b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 6)), (b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )
