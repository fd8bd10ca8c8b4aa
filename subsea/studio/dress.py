"""`subsea skin PHOTO --auto`: dress a species from a photograph, without a window."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.errors import UserError
from subsea.base.file_kinds import PICTURE, check_result
from subsea.base.files import check_file, read_input, replacing
from subsea.base.interrupts import deferred_interrupts
from subsea.base.progress import print_line
from subsea.base.system import ROOT, is_path
from subsea.fish.color_sheet import assign_sheet, own_sheet_path, write
from subsea.fish.species import Species, is_shipped, load_species, species_file
from subsea.studio.deformable_mesh import BODY, FishMeshes, attach_fins
from subsea.studio.fitting import FishFit, fin_errors, find_fish, outline_error, segment_under
from subsea.studio.lift import lift_sheet, mesh_mask
from subsea.studio.photograph import Photograph, read_photograph
from subsea.studio.side_view import centred_matrix, make_fish_meshes

GOOD = 0.015  # body lengths
FAR = 10.0  # of a photograph's size: farther meshes are refused
LEAST = 8.0  # pixels: a shorter body is refused


def dress(
    photo: Path, name: str, out: Path | None, flip: bool, mesh: Path | None, force: bool = False
) -> int:
    """Find the fish, make its sheet, save it for the species, and report the quality.

    With ``out`` only the sheet is written, there. Meshes are read from the file ``mesh`` if it
    exists, otherwise fitted and written to it.
    """
    species = load_species(name)
    path = species_file(name)
    if out is None and not is_editable(name):
        raise UserError(
            f"{name}: shipped species are not changed; give --out FILE.png, or copy "
            f"{path} to a species of your own and name that"
        )
    check_sheet(photo, name, out, force)
    check_mesh(mesh, flip)
    photograph = read_photograph(photo)
    with deferred_interrupts() as check:
        if mesh is not None and mesh.exists():
            meshes = load_mesh(mesh, photograph, species)
            one = FishFit(meshes, segment_under(photograph, meshes), 1.0)
        else:
            one = find_fish(photograph, species.surface, flip)
        check()
        sheet = lift_sheet(photograph.colour, one.meshes, species, one.mask)
        check()
        if mesh is not None and not mesh.exists():
            save_mesh(mesh, photograph, one.meshes)
            print_line(f"{mesh}: the meshes, to correct by hand or use again")
        if out is None:
            print_line(f"{assign_sheet(path, sheet)}: the sheet")
            print_line(f"{path}: skin.sheet names it")
        else:
            write(out, sheet)
            print_line(
                f"{out}: the sheet; to use it, put it beside a species file and set skin.sheet"
            )
    error = outline_error(one.meshes, one.mask)
    print(f"outline: {100 * error:.1f}% of the length, on average, from the segmented fish")
    fins = fin_errors(one.meshes, species.surface)
    for part, off in fins.items():
        print(f"{part} fin: root {100 * off:.1f}% of the length from the species' proportions")
    if not all(off <= GOOD for off in (error, *fins.values())):
        print("  that is much: look at the sheet, and correct the meshes in `subsea skin PHOTO`")
    left = one.meshes.body.nodes[4, 0, 0] < one.meshes.body.nodes[4, -1, 0]
    remedy = f"give --flip without {mesh}" if mesh is not None else "give --flip"
    print(f"heading: {'left' if left else 'right'}; if that is wrong, {remedy}")
    if out is None and not is_path(name, ".toml"):
        print_line(f"to see it: subsea dive --set fish.0.species={name}")
    return 0


def check_sheet(photo: Path, name: str, out: Path | None, force: bool = False) -> None:
    """Check that a sheet can be written to `out` or beside a species file, else UserError.

    The photograph is never replaced, and other files than pictures only with `force`.
    """
    if out is not None and out.suffix.lower() != ".png":
        raise UserError("expected the name of a file that ends in .png", file=out)
    target = out or species_file(name).with_suffix(".png")
    check_result(target, PICTURE, force)
    if target.exists() and photo.exists() and target.samefile(photo):
        raise UserError("is the photograph, which the sheet would replace; rename it", file=target)
    if out is None:
        own_sheet_path(species_file(name))


def check_mesh(mesh: Path | None, flip: bool) -> None:
    """Check that meshes can be written to a file or read from it, else UserError."""
    if mesh is not None:
        check_file(mesh)
        if flip and mesh.exists():
            raise UserError(
                "its meshes are used as they are, give it or --flip, not both", file=mesh
            )


def is_editable(name: str) -> bool:
    """True if a species file may be changed: a user's own, or any in a checkout."""
    return is_path(name, ".toml") or not is_shipped(name) or (ROOT / "pyproject.toml").exists()


def save_mesh(path: Path, photograph: Photograph, meshes: FishMeshes) -> None:
    """Write meshes as fractions of a photograph's size, so that they fit a larger copy too."""
    size = np.array(photograph.colour.shape[1::-1], float)
    content: dict[str, Any] = {
        name: {
            "nodes": (one.nodes / size).round(6).tolist(),
            "anchors": [
                [k, j, *(one.anchors[k, j] / size).round(6).tolist()]
                for k, j in np.argwhere(np.isfinite(one.anchors[..., 0])).tolist()
            ],
        }
        for name, one in meshes.parts.items()
    }
    with replacing(path) as temporary:
        temporary.write_text(
            json.dumps({"photograph": photograph.path.name, "meshes": content}, indent=1) + "\n",
            encoding="utf-8",
        )


def load_mesh(path: Path, photograph: Photograph, species: Species) -> FishMeshes:
    """Read meshes that `save_mesh` wrote; UserError for any other file."""
    height, width = photograph.colour.shape[:2]
    meshes = make_fish_meshes(species.surface, centred_matrix(width, height, species.surface))
    size = np.array([width, height], float)
    data = read_input(path)
    try:
        content = json.loads(data)["meshes"]
        if set(content) != set(meshes.parts):
            raise ValueError(f"expected meshes {', '.join(meshes.parts)}")
        for name, one in meshes.parts.items():
            nodes = np.array(content[name]["nodes"], float)
            if nodes.shape != one.nodes.shape or not (np.abs(nodes) < FAR).all():
                m, n, _ = one.nodes.shape
                raise ValueError(f"expected {m}×{n} nodes about the photograph")
            one.nodes[:] = nodes * size
            for k, j, *place in content[name]["anchors"]:
                anchor = np.array(place, float)
                if anchor.shape != (2,) or not (np.abs(anchor) < FAR).all():
                    raise ValueError("expected anchors about the photograph")
                one.anchors[k, j] = anchor * size
        if meshes.length < LEAST:
            raise ValueError(f"expected a {BODY} that is at least {LEAST:.0f} pixels long")
        if not mesh_mask(FishMeshes(meshes.body, {}), (height, width)).any():
            raise ValueError(f"expected a {BODY} over the photograph")
    except (ValueError, KeyError, TypeError, IndexError, OverflowError, RecursionError) as fault:
        raise UserError(f"no meshes of this species ({fault})", file=path) from fault
    attach_fins(meshes)
    return meshes
