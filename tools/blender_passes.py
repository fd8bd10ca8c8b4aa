"""Put the passes of a film together in Blender's compositor, and read a matte of Cryptomatte.

Blender is a large package of its own (`make blender` installs it into .venv/blender):

    .venv/blender/bin/python tools/blender_passes.py frame_00000.exr 1280 720 fusilier composed.exr

writes `composed.exr` with subject × transmittance + veil as Blender computes it. Its alpha is the
matte of that species.
"""

import sys
from pathlib import Path

import bpy


def main(frame: Path, size: tuple[int, int], species: str, out: Path) -> None:
    """Compose one frame of `size` (width, height): Blender does not tell that of many layers."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    tree = bpy.data.node_groups.new("passes", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    scene.compositing_node_group = tree
    image = bpy.data.images.load(str(frame))
    passes = tree.nodes.new("CompositorNodeImage")
    passes.image = image
    through = _mix(tree, "MULTIPLY", passes.outputs["subject"], passes.outputs["transmittance"])
    picture = _mix(tree, "ADD", through, passes.outputs["veil"])
    matte = tree.nodes.new("CompositorNodeCryptomatteV2")
    matte.source, matte.image = "IMAGE", image
    matte.layer_name, matte.matte_id = "CryptoSpecies", species
    both = tree.nodes.new("CompositorNodeSetAlpha")
    both.inputs["Type"].default_value = "Replace Alpha"
    tree.links.new(picture, both.inputs["Image"])
    tree.links.new(matte.outputs["Matte"], both.inputs["Alpha"])
    tree.links.new(both.outputs["Image"], tree.nodes.new("NodeGroupOutput").inputs[0])
    _render(scene, size, out)


def _mix(tree: bpy.types.NodeTree, kind: str, a: bpy.types.NodeSocket, b: bpy.types.NodeSocket):
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type, mix.blend_type, mix.clamp_result = "RGBA", kind, False
    factor, first, second = (mix.inputs[k] for k in (0, 6, 7))  # others are of numbers and vectors
    factor.default_value = 1.0
    tree.links.new(a, first)
    tree.links.new(b, second)
    return mix.outputs[2]


def _render(scene: bpy.types.Scene, size: tuple[int, int], out: Path) -> None:
    """Write what the compositor makes; the scene itself is empty."""
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples = "CYCLES", 1
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"
    scene.render.filepath = str(out)
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    picture, width, height, name, composed = sys.argv[1:]
    main(Path(picture), (int(width), int(height)), name, Path(composed))
