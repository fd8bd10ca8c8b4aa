"""Vertex animation textures of a scene with many fishes, in the layout of `vat.py` (OpenVAT).

Each species has one or more textures. A row is a pose: those of a fish follow one another, a row
for each frame, from its start frame on. Fishes are nodes that move, with the mesh at rest, for
programs whose shader reads the texture.
"""

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Ints
from subsea.base.errors import UserError
from subsea.base.file_kinds import PICTURE, check_result, json_file
from subsea.export.axes import Y_UP, to_metres
from subsea.export.glb import VERTICES
from subsea.export.gltf_parts import add_vertices
from subsea.export.gltf_scene_file import SceneFile
from subsea.export.licence import copyright_line
from subsea.export.png import png16
from subsea.export.scene import Scene
from subsea.export.vat import encode_points, texel_coordinates

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
