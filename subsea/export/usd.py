"""Export a species and its clips as a USD stage with points and normals in every frame.

All clips follow one another on the time line; `customLayerData` holds their first and last frames.
Units are metres, y is up and the head along +z, as in glTF. Body and fins are separate meshes,
because only fins are two-sided; transparent faces of the body, such as the tail's, are a subset.
"""

from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.errors import UserError
from subsea.base.files import replacing
from subsea.base.system import require
from subsea.export.axes import Y_UP, rotate_quaternions, to_metres
from subsea.export.clips import Clip, Model, bake_root, first_frames
from subsea.export.png import sheet_png
from subsea.export.usd_parts import animate, move, set_up, skin_materials, skin_meshes


def usd_files(folder: Path, name: str) -> list[Path]:
    """The files that `write_usd` writes: the stage and its texture."""
    return [folder / f"{name}.usdc", folder / f"{name}_basecolor.png"]


def write_usd(folder: Path, model: Model, clips: list[Clip], baked: bool) -> list[Path]:
    """Write the stage NAME.usdc and its texture into `folder`; return both files.

    The motion of the root is that of the model's prim, or `baked` into the points. UserError
    without usd-core or if a file cannot be written.
    """
    require("usd", "USD")
    from pxr import Tf, Usd

    file, sheet = usd_files(folder, model.name)
    stage = Usd.Stage.CreateInMemory(file.name)
    _fill(stage, sheet.name, model, clips, baked)
    with replacing(sheet) as picture, replacing(file) as part:
        picture.write_bytes(sheet_png(model.sheet))
        # The library needs the suffix, which an unfinished file does not have.
        plain = part.with_name(part.name + file.suffix)
        try:
            stage.GetRootLayer().Export(str(plain))
            plain.replace(part)
        except Tf.ErrorException as fault:
            raise UserError(f"cannot write ({fault.args[0].commentary})", file=file) from fault
        finally:
            plain.unlink(missing_ok=True)
    return [file, sheet]


def _fill(stage: Any, sheet: str, model: Model, clips: list[Clip], baked: bool) -> None:
    """Author the whole stage."""
    from pxr import Kind, Tf, Usd, UsdGeom

    first = first_frames(clips)
    last = [start + len(clip.points) - 1 for start, clip in zip(first, clips, strict=True)]
    spans = {
        clip.name: {"start": start, "end": end, "cyclic": clip.cyclic}
        for clip, start, end in zip(clips, first, last, strict=True)
    }
    set_up(stage, clips[0].fps, last[-1], [model.name], clips=spans)
    root = UsdGeom.Xform.Define(stage, f"/{Tf.MakeValidIdentifier(model.name)}")
    stage.SetDefaultPrim(root.GetPrim())
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    clips = [bake_root(clip) for clip in clips] if baked else clips
    if not baked:
        place = np.concatenate([clip.position for clip in clips])
        turn = np.concatenate([clip.rotation for clip in clips])
        move(root, to_metres(place, Y_UP), rotate_quaternions(turn, Y_UP))
    looks = skin_materials(stage, root.GetPath().AppendChild("materials"), sheet)
    for mesh, part in skin_meshes(stage, root.GetPath(), model, looks):
        for clip, start in zip(clips, first, strict=True):
            animate(mesh, part, zip(clip.points, clip.normals, strict=True), start)
