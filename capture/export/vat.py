"""A species and its clips as a vertex animation texture by the conventions of OpenVAT.

OpenVAT (https://github.com/sharpen3d/openvat, README and `Development/openvat/`, version 1.1.2) is
an encoder for Blender with decoders for several engines. What it writes with its standard settings
(normals packed, single row, PNG16) is a folder NAME_vat with

- NAME_vat.png, 16 bits: column i is a vertex, row f of the upper half frame f of all clips. Red,
  green and blue are how far the vertex is from its place at rest along x, y and z of Blender,
  between Min and Max. In the lower half, normals in the same places, from -1 to 1.
- NAME.glb: the mesh at rest. Its second texture coordinates are the middle of a vertex's texel in
  frame 0; frame f is f / height farther down, normals half of the texture.
- NAME-remap_info.json: Min, Max and Frames as `os-remap`, and the clips as `animations`, whose
  frames count from 1 and include the last.

Ours has the sheet of colours too, and what we know beyond that in the JSON's `subsea`.
"""

import json
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from capture.export.axes import METRES, Y_UP, Z_UP, rotate_quaternions, to_metres
from capture.export.clips import Clip, Model, bake_root
from capture.export.glb import CLAMPED, INDICES, VERTICES, GlbBuffer, glb, material
from capture.export.png import png16, sheet_png
from subsea.core.arrays import Array
from subsea.core.atomic_io import replacing

FULL = 65535  # the greatest value of a texel
ALPHA_CUTOFF = 0.3  # one material serves the body and fins: what is clearer is left out


class AnimationTexture(NamedTuple):
    """A vertex animation texture of n vertices and F frames."""

    texels: NDArray[np.uint16]  # (2F, n, 3): ways from rest, then normals
    low: Array  # (3,) metres, Blender's axes: what 0 stands for in the upper half ...
    high: Array  # ... and FULL
    first: list[int]  # each clip's first frame, from 0


def write_vat(folder: Path, model: Model, clips: list[Clip], baked: bool) -> list[Path]:
    """Write the folder NAME_vat into `folder`; return the files.

    The motion of the root is told in the JSON, or `baked` into the texture. A UserError if a file
    cannot be written.
    """
    texture = encode(model, clips, baked)
    folder = folder / f"{model.name}_vat"
    colours = f"{model.name}_basecolor.png"
    files = {
        f"{model.name}_vat.png": png16(texture.texels),
        colours: sheet_png(model.sheet),
        f"{model.name}.glb": _mesh(model, len(texture.texels), colours),
        f"{model.name}-remap_info.json": _ranges(model, clips, texture, baked),
    }
    with ExitStack() as all_or_none:
        for name, data in files.items():
            all_or_none.enter_context(replacing(folder / name)).write_bytes(data)
    return [folder / name for name in files]


def encode(model: Model, clips: list[Clip], baked: bool) -> AnimationTexture:
    """The texture of all clips, one after another."""
    if baked:
        clips = [bake_root(clip) for clip in clips]
    ways = to_metres(np.concatenate([clip.points for clip in clips]) - model.rest, Z_UP)
    low, high = ways.min(axis=(0, 1)), ways.max(axis=(0, 1))
    share = (ways - low) / np.where(high > low, high - low, 1.0)
    facing = 0.5 + 0.5 * (np.concatenate([clip.normals for clip in clips]) @ Z_UP.T)
    texels = np.round(FULL * np.clip(np.concatenate([share, facing]), 0.0, 1.0)).astype(np.uint16)
    first = np.cumsum([0, *(len(clip.points) for clip in clips[:-1])])
    return AnimationTexture(texels, low, high, first.tolist())


def places(count: int, height: int) -> Array:
    """Texture coordinates (count, 2) of the vertices in frame 0, from the upper left corner."""
    across = (np.arange(count) + 0.5) / count
    return np.stack([across, np.full(count, 0.5 / height)], axis=1)


def _mesh(model: Model, height: int, colours: str) -> bytes:
    """The mesh at rest, with the places of its vertices in the texture, as .glb."""
    buffer = GlbBuffer()

    def vertices(values: Array) -> int:
        return buffer.add(values.astype(np.float32), VERTICES)

    sheet = np.stack([model.uv[:, 0], 1.0 - model.uv[:, 1]], axis=1)
    primitive = {
        "attributes": {
            "POSITION": vertices(to_metres(model.rest, Y_UP)),
            "NORMAL": vertices(model.normals @ Y_UP.T),
            "TEXCOORD_0": vertices(sheet),
            "TEXCOORD_1": vertices(places(len(model.rest), height)),
        },
        "indices": buffer.add(model.triangles.astype(np.uint16).ravel(), INDICES),
        "material": 0,
    }
    looks = {"alphaMode": "MASK", "alphaCutoff": ALPHA_CUTOFF, "doubleSided": True}
    content = {
        "asset": {"version": "2.0", "generator": "subsea"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": model.name, "mesh": 0}],
        "meshes": [{"name": model.name, "primitives": [primitive]}],
        "materials": [material(model.name, looks)],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": CLAMPED, "wrapT": CLAMPED}],
        "images": [{"uri": quote(colours)}],
    }
    return glb(content, buffer)


def _ranges(model: Model, clips: list[Clip], texture: AnimationTexture, baked: bool) -> bytes:
    """The JSON: what OpenVAT's readers want, then what we know beyond that."""
    frames = len(texture.texels) // 2
    own: dict[str, Any] = {
        "bodyLength": METRES * model.length_cm,
        "framesPerSecond": float(clips[0].fps),
    }
    if not baked:
        own["root"] = {
            clip.name: {
                "position": np.round(to_metres(clip.position, Z_UP), 9).tolist(),
                "rotation": np.round(rotate_quaternions(clip.rotation, Z_UP), 9).tolist(),
            }
            for clip in clips
        }
    content = {
        "os-remap": {
            "Min": texture.low.tolist(),
            "Max": texture.high.tolist(),
            "Frames": frames,
        },
        "animations": {
            clip.name: {
                "startFrame": first + 1,
                "endFrame": first + len(clip.points),
                "framerate": round(clip.fps),
                "looping": clip.cyclic,
            }
            for clip, first in zip(clips, texture.first, strict=True)
        },
        "subsea": own,
    }
    return (json.dumps(content, indent=1) + "\n").encode()
