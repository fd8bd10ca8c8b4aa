"""Export a species and its clips as a vertex animation texture in the OpenVAT layout.

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

Vertex animation textures of a scene with many fishes, in the layout of `vat.py` (OpenVAT).

Each species has one or more textures. A row is a pose: those of a fish follow one another, a row
for each frame, from its start frame on. Fishes are nodes that move, with the mesh at rest, for
programs whose shader reads the texture.
"""

import json
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError
from subsea.base.file_kinds import PICTURE, check_result, json_file
from subsea.base.files import replacing
from subsea.export.axes import METRES, Y_UP, Z_UP, rotate_quaternions, to_metres
from subsea.export.clips import Clip, Model, bake_root, first_frames
from subsea.export.glb import CLAMPED, INDICES, VERTICES, GlbBuffer, asset, glb, material
from subsea.export.gltf import add_vertices
from subsea.export.gltf_scene_file import SceneFile
from subsea.export.licence import copyright_line
from subsea.export.png import png16, sheet_png
from subsea.export.scene import Scene

FULL = 65535  # the greatest value of a texel
ALPHA_CUTOFF = 0.3  # of the only material, for body and fins


class AnimationTexture(NamedTuple):
    """A vertex animation texture of n vertices and F frames."""

    texels: NDArray[np.uint16]  # (2F, n, 3): offsets from rest, then normals
    low: Array  # (3,) metres, Blender's axes: offset of value 0 ...
    high: Array  # ... and of FULL
    first: list[int]  # each clip's first frame, from 0


def vat_files(folder: Path, name: str) -> list[Path]:
    """The files that `write_vat` writes: animation texture, colours, mesh and ranges."""
    names = f"{name}_vat.png", f"{name}_basecolor.png", f"{name}.glb", f"{name}-remap_info.json"
    return [folder / f"{name}_vat" / one for one in names]


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
    """Encode all clips, one after another."""
    if baked:
        clips = [bake_root(clip) for clip in clips]
    points, normals = (
        np.concatenate(part)
        for part in zip(*((clip.points, clip.normals) for clip in clips), strict=True)
    )
    return encode_points(model, points, normals)._replace(first=first_frames(clips))


def encode_points(model: Model, points: Array, normals: Array) -> AnimationTexture:
    """Encode points, cm, body axes, and normals (F, n, 3)."""
    offsets = to_metres(points - model.rest, Z_UP)
    low, high = offsets.min(axis=(0, 1)), offsets.max(axis=(0, 1))
    share = (offsets - low) / np.where(high > low, high - low, 1.0)
    facing = 0.5 + 0.5 * (normals @ Z_UP.T)
    texels = np.round(FULL * np.clip(np.concatenate([share, facing]), 0.0, 1.0)).astype(np.uint16)
    return AnimationTexture(texels, low, high, [0])


def texel_coordinates(count: int, height: int) -> Array:
    """Texture coordinates (count, 2) of the vertices in frame 0, from the upper left corner."""
    across = (np.arange(count) + 0.5) / count
    return np.stack([across, np.full(count, 0.5 / height)], axis=1)


def _mesh(model: Model, height: int, colours: str) -> bytes:
    """The mesh at rest as .glb, with texture coordinates of the animation texture."""
    buffer = GlbBuffer()

    def vertices(values: Array) -> int:
        return buffer.add(values.astype(np.float32), VERTICES)

    sheet = np.stack([model.uv[:, 0], 1.0 - model.uv[:, 1]], axis=1)
    primitive = {
        "attributes": {
            "POSITION": vertices(to_metres(model.rest, Y_UP)),
            "NORMAL": vertices(model.normals @ Y_UP.T),
            "TEXCOORD_0": vertices(sheet),
            "TEXCOORD_1": vertices(texel_coordinates(len(model.rest), height)),
        },
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
        "materials": [material(model.name, looks)],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": CLAMPED, "wrapT": CLAMPED}],
        "images": [{"uri": quote(colours)}],
    }
    return glb(content, buffer)


def _ranges(model: Model, clips: list[Clip], texture: AnimationTexture, baked: bool) -> bytes:
    """The JSON: the keys of OpenVAT, then our own."""
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


ROWS = 4096  # poses in a texture: with normals 8192 rows, as engines read
PACKED = 0.75  # of the bytes of texels that PNG leaves
JSON = json_file("a description of an OpenVAT texture", "os-remap")


class _Page(NamedTuple):
    """The fishes of a texture."""

    name: str
    model: int
    fishes: list[int]


def texture_bytes(frames: int, vertices: Ints) -> int:
    """About the bytes of textures of fishes with these numbers of vertices."""
    return int(PACKED * 12 * frames * vertices.sum())


def check_textures(out: Path, force: bool) -> None:
    """Refuse to replace files of other kinds in the folder of the textures of `out`."""
    for path in sorted(_folder(out).glob("*")):
        check_result(path, PICTURE if path.suffix == ".png" else JSON, force)


def add_textures(file: SceneFile, out: Path) -> dict[Path, bytes]:
    """Add all fishes as meshes at rest; return the textures and their descriptions to write."""
    scene = file.scene
    files: dict[Path, bytes] = {}
    for page in _pages(scene):
        model = scene.models[page.model]
        parts = [scene.points(fish) for fish in page.fishes]
        sizes = [scene.fishes[fish].scale for fish in page.fishes]
        points = np.concatenate([part[0] / size for part, size in zip(parts, sizes, strict=True)])
        texture = encode_points(model, points, np.concatenate([part[1] for part in parts]))
        height, name = len(texture.texels), f"{page.name}_vat.png"
        grid = file.buffer.packing.grid(to_metres(model.rest, Y_UP))
        texels = texel_coordinates(len(model.rest), height).astype(np.float32)
        attributes = add_vertices(file.buffer, model, grid)
        attributes["TEXCOORD_1"] = file.buffer.add(texels, VERTICES)
        first = 0
        animations: dict[str, Any] = {}
        for fish, part in zip(page.fishes, parts, strict=True):
            one = scene.fishes[fish]
            _, node = file.add_path(fish)
            mesh = file.add_mesh(fish, attributes)
            node["children"] = [file.node({"name": f"{one.name}_mesh", "mesh": mesh} | grid.node())]
            node["extras"] |= {
                "texture": f"{_folder(out).name}/{name}",
                "firstRow": first,
                "firstFrame": one.first,
                "lastFrame": one.last,
            }
            animations[one.name] = {
                "startFrame": first + 1,
                "endFrame": first + len(part[0]),
                "framerate": round(scene.fps),
                "looping": False,
            }
            first += len(part[0])
        files[_folder(out) / name] = png16(texture.texels)
        content = {
            "os-remap": {
                "Min": texture.low.tolist(),
                "Max": texture.high.tolist(),
                "Frames": height // 2,
            },
            "animations": animations,
            "subsea": {
                "framesPerSecond": scene.fps,
                "copyright": copyright_line([model.name]),
            },
        }
        text = (json.dumps(content, indent=1) + "\n").encode()
        files[_folder(out) / f"{page.name}-remap_info.json"] = text
    return files


def _folder(out: Path) -> Path:
    return out.with_name(f"{out.stem}_vat")


def _pages(scene: Scene) -> list[_Page]:
    """The textures: as many fishes of a species in each as fit."""
    out: list[_Page] = []
    for model, species in enumerate(scene.models):
        free, number = 0, 0
        for fish, one in enumerate(scene.fishes):
            if one.model != model:
                continue
            count = one.last - one.first + 1
            if count > ROWS:
                raise UserError(
                    f"{count} frames do not fit into a texture, expected at most {ROWS}; "
                    "use fewer seconds or frames per second"
                )
            if count > free:
                number += 1
                free = ROWS
                out.append(_Page(f"{species.name}_{number}", model, []))
            out[-1].fishes.append(fish)
            free -= count
    return out
