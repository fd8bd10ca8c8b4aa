"""`subsea skin PHOTO --auto`: a species is dressed from a photograph, without a window."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from subsea.core.atomic_io import check_file, replacing
from subsea.core.errors import UserError
from subsea.core.interrupts import deferred_interrupts
from subsea.core.resources import ROOT, is_path
from subsea.fish.color_sheet import picture_of, wear, write
from subsea.fish.photo.deformable_mesh import BODY, Net, meshes, root
from subsea.fish.photo.fitting import Found, found, outline_error, under
from subsea.fish.photo.lift import covered, lifted
from subsea.fish.photo.photograph import Photograph, read
from subsea.fish.photo.side_view import across, laid
from subsea.fish.species import Species, is_shipped, load_species, species_file

GOOD = 0.015  # body lengths
FAR = 10.0  # of a photograph's size: meshes that lie so far off are none
LEAST = 8.0  # pixels: a body that is shorter is none


def dress(photo: Path, name: str, out: Path | None, flip: bool, mesh: Path | None) -> int:
    """Find the fish, lift its skin, let the species wear it, and say how well it went.

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
    photograph = read(photo)
    with deferred_interrupts() as check:
        if mesh is not None and mesh.exists():
            net = load_mesh(mesh, photograph, species)
            one = Found(net, under(photograph, net), 1.0)
        else:
            one = found(photograph, species.surface, flip)
        check()
        sheet = lifted(photograph.colour, one.net, species, one.mask)
        check()
        if mesh is not None and not mesh.exists():
            save_mesh(mesh, photograph, one.net)
            print(f"{mesh}: the meshes, to be mended by hand or used again")
        if out is None:
            print(f"{wear(path, sheet)}: the sheet")
            print(f"{path}: skin.sheet names it")
        else:
            write(out, sheet)
            print(
                f"{out}: the sheet; a species wears it by skin.sheet, with the PNG beside its file"
            )
    error = outline_error(one.net, one.mask)
    print(f"outline: {100 * error:.1f}% of the length, on average, from what was told apart")
    if not error <= GOOD:
        print("  that is much: look at the sheet, and mend the meshes in `subsea skin PHOTO`")
    left = one.net.body.nodes[4, 0, 0] < one.net.body.nodes[4, -1, 0]
    mend = f"give --flip without {mesh}" if mesh is not None else "give --flip"
    print(f"heading: {'left' if left else 'right'}; if it is the other way, {mend}")
    if out is None and not is_path(name, ".toml"):
        print(f"to see it: subsea dive --set fish.0.species={name}")
    return 0


def check_sheet(photo: Path, name: str, out: Path | None) -> None:
    """Whether a sheet can be written to `out`, or beside the file of a species; else a UserError.

    The photograph, and what else lies there and is no sheet of the species, is not written over.
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
    """Whether meshes can be written to a file, or taken from it as they are; else a UserError."""
    if mesh is not None:
        check_file(mesh)
        if flip and mesh.exists():
            raise UserError(
                "its meshes are used as they are, give it or --flip, not both", file=mesh
            )


def may_wear(name: str) -> bool:
    """Whether the file of a species may be changed: one's own, or any in a checkout."""
    return is_path(name, ".toml") or not is_shipped(name) or (ROOT / "pyproject.toml").exists()


def save_mesh(path: Path, photograph: Photograph, net: Net) -> None:
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
        for name, one in meshes(net).items()
    }
    with replacing(path) as temporary:
        temporary.write_text(
            json.dumps({"photograph": photograph.path.name, "meshes": content}, indent=1) + "\n",
            encoding="utf-8",
        )


def load_mesh(path: Path, photograph: Photograph, species: Species) -> Net:
    """Meshes as `save_mesh` writes them; what is no such file is a UserError."""
    height, width = photograph.colour.shape[:2]
    net = laid(species.surface, across(width, height, species.surface))
    size = np.array([width, height], float)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))["meshes"]
        if set(content) != set(meshes(net)):
            raise ValueError(f"expected meshes {', '.join(meshes(net))}")
        for name, one in meshes(net).items():
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
        if np.hypot(*(net.body.nodes[4, 0] - net.body.nodes[4, -1])) < LEAST:
            raise ValueError(f"expected a {BODY} that is at least {LEAST:.0f} pixels long")
        if not covered(Net(net.body, {}), (height, width)).any():
            raise ValueError(f"expected a {BODY} over the photograph")
    except OSError as fault:
        raise UserError(f"cannot read ({fault.strerror})", file=path) from fault
    except (ValueError, KeyError, TypeError, IndexError, OverflowError, RecursionError) as fault:
        raise UserError(f"no meshes of this species ({fault})", file=path) from fault
    root(net)
    return net
