"""Open an exported scene in Blender, show a frame of it, and tell where its vertices are.

Blender is a large package of its own (`make blender` installs it into .venv/blender):

    .venv/blender/bin/python tools/blender_scene.py reef.glb 30 45 points.npz frame.png

shows frame 45 of a scene of 30 frames a second. `points.npz` has the vertices of each mesh in
world axes, metres; `frame.png` is the view of the exported camera, drawn on the processor.
"""

import sys
from pathlib import Path

import bpy
import numpy as np

WATER = (0.02, 0.13, 0.26, 1.0)  # linear; about that of the dive
SUN = (0.35, 0.25, 0.0)  # rad, rotation of the light
SIZE, SAMPLES = (640, 360), 24


def main(scene_file: Path, fps: int, frame: int, points: Path, picture: Path | None) -> None:
    """Import a scene, show a frame, write the points and the picture."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = fps  # the times of glTF are seconds
    if scene_file.suffix == ".glb":
        bpy.ops.import_scene.gltf(filepath=str(scene_file))
    else:
        bpy.ops.wm.usd_import(filepath=str(scene_file), set_frame_range=True)
    first = 0 if scene_file.suffix == ".glb" else scene.frame_start
    scene.frame_set(first + frame)
    np.savez(points, **_points())
    print(f"Blender {bpy.app.version_string}: frame {frame}, {len(bpy.data.objects)} objects")
    if picture is not None:
        _render(picture)


def _points() -> dict[str, np.ndarray]:
    """World positions (n, 3) of each mesh's vertices, by its name and those of its parents."""
    graph = bpy.context.evaluated_depsgraph_get()
    found = {}
    for thing in bpy.context.scene.objects:
        if thing.type != "MESH" or thing.hide_get():
            continue
        shown = thing.evaluated_get(graph)
        mesh = shown.to_mesh()
        places = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", places)
        matrix = np.array(shown.matrix_world)
        found[_path(thing)] = places.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        shown.to_mesh_clear()
    return found


def _path(thing: bpy.types.Object) -> str:
    return thing.name if thing.parent is None else f"{_path(thing.parent)}/{thing.name}"


def _render(picture: Path) -> None:
    """Draw what the exported camera sees in plain water."""
    scene = bpy.context.scene
    scene.camera = next(one for one in scene.objects if one.type == "CAMERA")
    world = scene.world = bpy.data.worlds.new("water")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = WATER
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 3.0, SUN
    scene.collection.objects.link(sun)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = SAMPLES, False
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.view_settings.view_transform = "Standard"
    scene.render.filepath = str(picture)
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    out = Path(sys.argv[5]) if len(sys.argv) > 5 else None
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4]), out)
