"""Make the picture of docs/how-to/export.md: exported files in Blender.

Blender is not part of the project; its module needs a separate environment:

    python3.11 -m venv /tmp/blender && /tmp/blender/bin/pip install bpy==4.4.0 "numpy<2" pillow
    for form in gltf usd vat; do subsea-capture export fusilier --to $form --out /tmp/exported; done
    /tmp/blender/bin/python docs/make_export_pictures.py /tmp/exported docs/pictures/exported.png
"""

import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Quaternion, Vector
from PIL import Image, ImageDraw, ImageFont

NAME, CLIP = "fusilier", "turn_left_sharp"
FRAMES = (0, 14, 28, 42)  # of the clip
SIZE = (300, 240)
EYE, MIDDLE = Vector((0.34, -0.42, 0.3)), Vector((0.025, -0.086, 0.0))  # m, as the clip begins
WATER = (0.16, 0.34, 0.44, 1.0)
SAMPLES = 64

Show = Callable[[int], None]  # a frame of the clip


def usd(folder: Path) -> Show:
    """Set up the stage; a clip is a part of its time line."""
    bpy.ops.wm.usd_import(filepath=str(folder / f"{NAME}.usdc"))
    first = _ranges(folder)["animations"][CLIP]["startFrame"] - 1  # all formats have one order
    return lambda frame: bpy.context.scene.frame_set(first + frame)


def vat(folder: Path) -> Show:
    """Decode the texture as a shader does; move the root by the JSON."""
    folder /= f"{NAME}_vat"
    bpy.ops.import_scene.gltf(filepath=str(folder / f"{NAME}.glb"))
    [fish] = [thing for thing in bpy.context.scene.objects if thing.type == "MESH"]
    mesh = fish.data
    picture = bpy.data.images.load(str(folder / f"{NAME}_vat.png"))
    picture.colorspace_settings.name = "Non-Color"
    width, height = picture.size
    texels = np.array(picture.pixels, np.float32).reshape(height, width, 4)[..., :3]
    loops = np.array([loop.vertex_index for loop in mesh.loops])
    uv = np.empty((len(mesh.vertices), 2))
    uv[loops] = [place.uv for place in mesh.uv_layers[1].data]
    rest = np.array([vertex.co for vertex in mesh.vertices])
    ranges = _ranges(folder.parent)
    low, high = (np.array(ranges["os-remap"][name]) for name in ("Min", "Max"))
    first, root = ranges["animations"][CLIP]["startFrame"] - 1, ranges["subsea"]["root"][CLIP]

    def show(frame: int) -> None:
        row = np.floor(uv[:, 1] * height - (first + frame)).astype(int)  # Blender's v is upwards
        way = low + texels[row, (uv[:, 0] * width).astype(int)] * (high - low)
        mesh.vertices.foreach_set("co", (rest + way).ravel())
        mesh.update()
        turn = Quaternion(root["rotation"][frame]).to_matrix().to_4x4()
        fish.matrix_world = Matrix.Translation(root["position"][frame]) @ turn

    return show


def gltf(folder: Path) -> Show:
    """Set up the skinned mesh; an action is a clip."""
    bpy.ops.import_scene.gltf(filepath=str(folder / f"{NAME}.glb"))
    [rig] = [thing for thing in bpy.context.scene.objects if thing.type == "ARMATURE"]
    for track in rig.animation_data.nla_tracks:
        track.mute = True
    rig.animation_data.action = action = bpy.data.actions[CLIP]
    rig.animation_data.action_slot = action.slots[0]
    rate = _ranges(folder)["subsea"]["framesPerSecond"]

    def show(frame: int) -> None:
        whole, part = divmod(frame / rate * bpy.context.scene.render.fps, 1.0)
        bpy.context.scene.frame_set(int(whole), subframe=part)

    return show


ROWS = {"glTF": gltf, "USD": usd, "vertex animation texture": vat}


def main(folder: Path, out: Path) -> None:
    """Draw the frames of a clip from the files of each format."""
    page = Image.new("RGB", (SIZE[0] * len(FRAMES), SIZE[1] * len(ROWS)))
    for y, (title, load) in enumerate(ROWS.items()):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        show = load(folder)
        _studio()
        for x, frame in enumerate(FRAMES):
            show(frame)
            page.paste(_picture(), (x * SIZE[0], y * SIZE[1]))
        ImageDraw.Draw(page).text((8, y * SIZE[1] + 6), title, "white", ImageFont.load_default(15))
    page.save(out)


def _ranges(folder: Path) -> dict:
    return json.loads((folder / f"{NAME}_vat" / f"{NAME}-remap_info.json").read_text())


def _studio() -> None:
    """Add a sun, water and the camera."""
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("water")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = WATER
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 3.5, (0.5, 0.45, 0.0)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = EYE
    camera.rotation_euler = (MIDDLE - EYE).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens, camera.data.clip_start = 80.0, 0.01
    for thing in (sun, camera):
        scene.collection.objects.link(thing)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = SAMPLES, False
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.view_settings.view_transform = "Standard"


def _picture() -> Image.Image:
    with tempfile.TemporaryDirectory() as folder:
        bpy.context.scene.render.filepath = str(Path(folder) / "frame.png")
        bpy.ops.render.render(write_still=True)
        return Image.open(Path(folder) / "frame.png").convert("RGB")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
