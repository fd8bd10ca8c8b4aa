"""Calibrate a theatre: from photographs to meshes, masks and a new theatre file."""

import io
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.files import read_text, replacing
from subsea.base.pictures import write_png
from subsea.base.progress import count_noun, print_line, progress, say
from subsea.base.system import require
from subsea.base.toml_edit import edit_toml
from subsea.stage.calibration.blending import (
    Footprint,
    footprints,
    light_share,
    mesh_of,
    overlap_blacks,
)
from subsea.stage.calibration.decode import decode
from subsea.stage.calibration.light_levels import LightLevels, light_levels
from subsea.stage.calibration.lit_theatre import LitTheatre, lit_theatre
from subsea.stage.calibration.meshes import (
    MeasuredProjector,
    away_from_plan,
    measure_projector,
    planned_projector,
)
from subsea.stage.calibration.optics import (
    ORDINARY,
    ReferencePoint,
    SeenLight,
    SolvedCamera,
    solve_camera,
)
from subsea.stage.calibration.photographs import (
    POINTS,
    camera_folders,
    light_steps,
    ordered,
)
from subsea.stage.calibration.points import points_template, read_points
from subsea.stage.calibration.residuals import residual_picture
from subsea.stage.calibration.surface import LitSurface
from subsea.stage.theatre.theatre_writer import check_free, compose_obj
from subsea.stage.theatre.warp import validated
from subsea.view.structured_light import light_picture

MOST_SEEN = 0.9  # share of a picture below which a line warns
FAR_POINT, FAR_POINT_PX = 0.004, 5.0  # side of a photograph, or pixels, that a point may be off
FAR_FROM_PLAN = 0.2  # diagonals of a picture beyond which a line warns
NOT_STRAIGHT_PX = 3.0  # rms error of projectors as lenses beyond which a line warns


@dataclass(frozen=True)
class CalibrationOptions:
    """Options of a calibration."""

    photographs: Path
    points: Path | None = None  # None: points.toml in the folder of each camera
    out: Path | None = None  # None: NAME-calibrated.toml beside the theatre file
    force: bool = False


def write_patterns(name: str, folder: Path, force: bool = False) -> None:
    """Write the structured light of a theatre as pictures, and a file of points to fill in."""
    lit = lit_theatre(name)
    steps = light_steps(lit.channels)
    points = folder / POINTS
    files = [folder / f"{number:04d}-{step.name}-{step.pattern.name}.png"
             for number, step in enumerate(steps, 1)]  # fmt: skip
    for path in (points, *files):
        check_free(path, force)
    folder.mkdir(parents=True, exist_ok=True)
    text = points_template(np.array(lit.theatre.eye_cm), lit.surfaces)
    with replacing(points) as part:
        part.write_text(text, encoding="utf-8")
    for step, path in zip(steps, files, strict=True):
        width, height = lit.channels[step.channel].place[2:]
        write_png(path, np.ascontiguousarray(light_picture(step.pattern, (width, height))))
    print_line(f"{count_noun(len(files), 'pattern', 'patterns')} and {points}")


def calibrate(name: str, options: CalibrationOptions) -> None:
    """Measure the projectors of a theatre by photographs, and write a calibrated theatre file.

    Prints a line for each camera and projector. Nothing is written if a photograph does not fit.
    """
    require("calibrate", "--calibrate")
    lit = lit_theatre(name)
    surfaces = lit.surfaces
    out = options.out or lit.path.with_name(f"{lit.path.stem}-calibrated.toml")
    if out.resolve().parent != lit.path.resolve().parent:
        raise UserError(
            f"expected a file in {lit.path.parent}, because the theatre names files there", file=out
        )
    names = [channel.name for channel in lit.channels]
    files = CalibrationFiles(out, names)
    for path in files.all:
        check_free(path, options.force)
    seen, cameras = _solved(lit, surfaces, options)
    sizes = {k: (one.place[2], one.place[3]) for k, one in enumerate(lit.channels)}
    measured: list[MeasuredProjector] = []
    for k, channel in enumerate(lit.channels):
        own = [(one, cameras[one.camera].camera) for one in seen if one.channel == k]
        found = measure_projector(surfaces[k], sizes[k], own)
        if found is None:
            say(f"{channel.name} was not seen; it keeps the mesh of {lit.path.name}")
        measured.append(found or planned_projector(surfaces[k], channel))
    groups = [channel.eye for channel in lit.channels]
    prints = footprints(measured, surfaces, groups)
    levels = light_levels(seen, len(lit.channels))
    _report(lit, prints, levels)
    _write(lit, files, prints, levels, groups)


def _solved(
    lit: LitTheatre, surfaces: list[LitSurface], options: CalibrationOptions
) -> tuple[list[SeenLight], list[SolvedCamera]]:
    """Decode the photographs of all cameras, and solve where they stood."""
    steps = light_steps(lit.channels)
    sizes = {k: (one.place[2], one.place[3]) for k, one in enumerate(lit.channels)}
    eye = np.array(lit.theatre.eye_cm)
    folders = camera_folders(options.photographs)
    if options.points is not None and len(folders) > 1:
        raise UserError(f"--points is for one camera; expected {POINTS} in each camera's folder")
    taken = []
    for folder in folders:
        path = options.points or folder / POINTS
        taken.append((folder, path, read_points(path, eye, surfaces), ordered(folder, steps)))
    seen: list[SeenLight] = []
    solved: list[SolvedCamera] = []
    with progress(len(steps) * len(folders), "photograph") as done:
        for number, (folder, path, points, paths) in enumerate(taken):
            found, size = decode(paths, steps, number, done)
            if not found:
                raise UserError(
                    "too dark: no projector is seen; expected a longer exposure", file=folder
                )
            camera = solve_camera(size, points, found, dict(enumerate(surfaces)), sizes)
            check_camera(camera, points, path)
            say(f"{folder.name}: {_camera_words(camera)}")
            seen += found
            solved.append(camera)
    return seen, solved


def check_camera(solved: SolvedCamera, points: Sequence[ReferencePoint], path: Path | str) -> None:
    """Refuse reference points, of the file `path`, that contradict the photographs."""
    worst = int(np.argmax(solved.point_px))
    if not solved.point_px[worst] <= max(FAR_POINT * max(solved.camera.size), FAR_POINT_PX):
        raise UserError(
            f"{points[worst].name!r} is {solved.point_px[worst]:.0f} pixels from where the other "
            "points and the projectors put it; expected its place in the room and its `pixel` in "
            "these photographs of this room",
            file=path,
        )
    if not solved.light_px <= NOT_STRAIGHT_PX:
        say(
            f"{path}: the light differs by {solved.light_px:.1f} pixels from that of "
            "projectors that draw straight lines; is the shape of the screen right?"
        )


def _camera_words(solved: SolvedCamera) -> str:
    """A camera, for a message."""
    camera = solved.camera
    place = ", ".join(f"{x:.0f}" for x in camera.place)
    point_px = np.sqrt(np.mean(solved.point_px**2))
    article = "an" if camera.lens == ORDINARY else "a"
    return (
        f"{article} {camera.lens} lens at {place} cm from the best seat; "
        f"points within {point_px:.1f} pixels rms"
    )


def _report(lit: LitTheatre, prints: Sequence[Footprint], levels: Sequence[LightLevels]) -> None:
    """Print a line for each projector, and warn of parts that were not seen."""
    for channel, one, level in zip(lit.channels, prints, levels, strict=True):
        if not one.measured.seen:
            continue
        share = one.seen_share
        gain = " ".join(f"{part:.2f}" for part in level.gain)
        print_line(
            f"{channel.name}: {100 * share:.0f}% seen, {one.measured.rms_px:.2f} pixels rms, "
            f"gain {gain}, black {level.black:.4f}"
        )
        if share < MOST_SEEN:
            say(f"{channel.name}: {100 * share:.0f}% of it was seen; its lens gives the rest")
        if (away := away_from_plan(one.measured, channel)) > FAR_FROM_PLAN:
            say(
                f"{channel.name}: its light lies {100 * away:.0f}% of its diagonal from where "
                f"{lit.path.name} has it; are these photographs of this room, and is it on its own "
                "cable?"
            )


class CalibrationFiles:
    """The files that a calibration writes."""

    def __init__(self, out: Path, names: Sequence[str]) -> None:
        self.theatre = out
        stems = [out.with_name(f"{out.stem}-{name}") for name in names]
        self.meshes = [stem.with_name(f"{stem.name}.obj") for stem in stems]
        self.masks = [stem.with_name(f"{stem.name}-mask.png") for stem in stems]
        self.blacks = [stem.with_name(f"{stem.name}-black.png") for stem in stems]
        self.residuals = [stem.with_name(f"{stem.name}-residuals.png") for stem in stems]
        self.all = [out, *self.meshes, *self.masks, *self.blacks, *self.residuals]


def _write(
    lit: LitTheatre,
    files: CalibrationFiles,
    prints: Sequence[Footprint],
    levels: Sequence[LightLevels],
    groups: Sequence[object],
) -> None:
    """Write meshes, masks, residuals, and last the theatre file that names them."""
    text = read_text(lit.path)
    old = tomllib.loads(text)
    tables: list[dict[str, Any]] = [dict(table) for table in old["channel"]]
    lifted = overlap_blacks(prints, [level.black for level in levels], groups)
    most = max(float(one.max()) for one in lifted)
    for k, (channel, one, level) in enumerate(zip(lit.channels, prints, levels, strict=True)):
        table = tables[int(channel.key[8:-1])]
        gamma = level.gamma or channel.adjustment.gamma
        share = light_share(prints, k, groups)[..., None] * (1.0 - most)
        factor = share ** (1.0 / np.array(gamma))
        _write_png(files.masks[k], np.round(255 * factor).astype(np.uint8))
        table |= {"warp": files.meshes[k].name, "mask": files.masks[k].name}
        if most > 0.0:
            _write_png(files.blacks[k], np.round(65535 * lifted[k]).astype(np.uint16))
            table["black_mask"] = files.blacks[k].name
        part = one.part
        if channel.screen is not None:
            table["part"] = _within_whole(table.get("part"), part)
        else:
            part = (0.0, 0.0, 1.0, 1.0)
        warp = validated(mesh_of(one.measured, part), str(files.meshes[k]))
        with replacing(files.meshes[k]) as partial:
            partial.write_text(compose_obj(warp), encoding="utf-8")
        if level.gain != (1.0, 1.0, 1.0):
            table["gain"] = list(level.gain)
        if level.gamma is not None:
            table["gamma"] = list(level.gamma)
        for key in ("blend", "blend_width", "black"):  # the masks have them now
            table.pop(key, None)
        if {"flip", "rotate"} & table.keys():
            table.pop("edge_mask", None)  # its places were turned
        for key in ("flip", "rotate", "corners_px", "points_px"):  # the mesh has them now
            table.pop(key, None)
        if one.measured.seen:
            write_png(files.residuals[k], residual_picture(channel.name, one.measured))
    new = {**old, "channel": tables}
    with replacing(files.theatre) as partial:
        partial.write_text(edit_toml(text, old, new, file=lit.path), encoding="utf-8")
    print_line(f"wrote {files.theatre}")


def _within_whole(
    given: Sequence[float] | None, part: tuple[float, float, float, float]
) -> list[float]:
    """A part (x, y, width, height) of the part `given` of a screen, as part of the screen."""
    x, y, width, height = given or (0.0, 0.0, 1.0, 1.0)
    return [
        round(x + part[0] * width, 6), round(y + part[1] * height, 6),
        round(part[2] * width, 6), round(part[3] * height, 6),
    ]  # fmt: skip


def _write_png(path: Path, numbers: Array) -> None:
    packed = io.BytesIO()
    Image.fromarray(numbers).save(packed, "PNG")
    with replacing(path) as partial:
        partial.write_bytes(packed.getvalue())
