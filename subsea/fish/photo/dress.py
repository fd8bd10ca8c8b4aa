"""`subsea skin PHOTO --auto`: dress a species from a photograph, without a window."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from subsea.core.atomic_io import check_file, replacing
from subsea.core.errors import UserError
from subsea.core.interrupts import deferred_interrupts
from subsea.core.resources import ROOT, is_path
from subsea.fish.color_sheet import picture_of, wear, write
from subsea.fish.photo.deformable_mesh import BODY, FishMeshes, attach_fins
from subsea.fish.photo.fitting import FishFit, find_fish, outline_error, segment_under
from subsea.fish.photo.lift import lift_sheet, mesh_mask
from subsea.fish.photo.photograph import Photograph, read_photograph
from subsea.fish.photo.side_view import centred_matrix, make_fish_meshes
from subsea.fish.species import Species, is_shipped, load_species, species_file

GOOD = 0.015  # body lengths
FAR = 10.0  # of a photograph's size: farther meshes are refused
LEAST = 8.0  # pixels: a shorter body is refused


def dress(photo: Path, name: str, out: Path | None, flip: bool, mesh: Path | None) -> int:
    """Find the fish, lift its skin, save it for the species, and report the quality.

    With ``out`` the sheet alone is written there. ``mesh`` holds the meshes: those of a file that
    is there are taken as they are, else the file is made.
    """
    species = load_species(name)
    path = species_file(name)
    if out is None and not may_wear(name):
        raise UserError(
            f"{name}: a species that is shipped stays as it is; give --out FILE.png, or copy "
            f"{path} to a species of your own and name that"
        )
    check_sheet(photo, name, out)
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
            print(f"{mesh}: the meshes, to be mended by hand or used again")
        if out is None:
            print(f"{wear(path, sheet)}: the sheet")
            print(f"{path}: skin.sheet names it")
        else:
            write(out, sheet)
            print(
                f"{out}: the sheet; a species wears it by skin.sheet, with the PNG beside its file"
            )
    error = outline_error(one.meshes, one.mask)
    print(f"outline: {100 * error:.1f}% of the length, on average, from what was told apart")
    if not error <= GOOD:
        print("  that is much: look at the sheet, and mend the meshes in `subsea skin PHOTO`")
    left = one.meshes.body.nodes[4, 0, 0] < one.meshes.body.nodes[4, -1, 0]
    mend = f"give --flip without {mesh}" if mesh is not None else "give --flip"
    print(f"heading: {'left' if left else 'right'}; if it is the other way, {mend}")
    if out is None and not is_path(name, ".toml"):
        print(f"to see it: subsea dive --set fish.0.species={name}")
    return 0


def check_sheet(photo: Path, name: str, out: Path | None) -> None:
    """Check that a sheet can be written to `out` or beside a species file, else UserError.

    The photograph, and other files that are not sheets of the species, are not overwritten.
    """
    if out is not None and out.suffix.lower() != ".png":
        raise UserError("expected the name of a file that ends in .png", file=out)
    target = out or species_file(name).with_suffix(".png")
    check_file(target)
    if target.exists() and photo.exists() and target.samefile(photo):
        raise UserError("is the photograph, which the sheet would replace; rename it", file=target)
    if out is None:
        picture_of(species_file(name))


def check_mesh(mesh: Path | None, flip: bool) -> None:
    """Check that meshes can be written to a file or read from it, else UserError."""
    if mesh is not None:
        check_file(mesh)
        if flip and mesh.exists():
            raise UserError(
                "its meshes are used as they are, give it or --flip, not both", file=mesh
            )


def may_wear(name: str) -> bool:
    """Return whether a species file may be changed: a user's own, or any in a checkout."""
    return is_path(name, ".toml") or not is_shipped(name) or (ROOT / "pyproject.toml").exists()


def save_mesh(path: Path, photograph: Photograph, meshes: FishMeshes) -> None:
    """Write meshes as shares of a photograph's size, so that a larger copy of it fits too."""
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
    """Read meshes that `save_mesh` wrote; any other file is a UserError."""
    height, width = photograph.colour.shape[:2]
    meshes = make_fish_meshes(species.surface, centred_matrix(width, height, species.surface))
    size = np.array([width, height], float)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))["meshes"]
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
        if np.hypot(*(meshes.body.nodes[4, 0] - meshes.body.nodes[4, -1])) < LEAST:
            raise ValueError(f"expected a {BODY} that is at least {LEAST:.0f} pixels long")
        if not mesh_mask(FishMeshes(meshes.body, {}), (height, width)).any():
            raise ValueError(f"expected a {BODY} over the photograph")
    except OSError as fault:
        raise UserError(f"cannot read ({fault.strerror})", file=path) from fault
    except (ValueError, KeyError, TypeError, IndexError, OverflowError, RecursionError) as fault:
        raise UserError(f"no meshes of this species ({fault})", file=path) from fault
    attach_fins(meshes)
    return meshes
