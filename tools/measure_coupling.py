"""Measure the distortion of the surface by the three kinds of coupling to the nodes.

.venv/bin/python tools/measure_coupling.py [SPECIES...]

Over all frames of a fast swim and a sharp turn, for both flanks: the least and greatest area of a
patch relative to rest, and the greatest increase of the angle between consecutive patches.
"""

import sys
from collections.abc import Iterator
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from subsea.fish.skinning import CouplingMethod, couple, place
from subsea.fish.species import load_species, repertoire_file
from subsea.fish.surface import LEFT, RIGHT, U, V, rest_control_points
from subsea.geometry.curves import basis_at, dense
from subsea.repertoire import read_repertoire

Array = NDArray[np.floating[Any]]

SEGMENTS = "swim_fast", "turn_left_sharp"
PATCHES = 48, 120  # of a flank, across it and along the body


def flanks(control: Array) -> Iterator[Array]:
    """The surface (49, 121, 3) of the left and of the right flank of control points (426, 3)."""
    across, along = (
        dense(basis_at(number, np.linspace(0.0, 1.0, patches + 1)), number)
        for number, patches in zip((U, V), PATCHES, strict=True)
    )
    for flank in (LEFT, RIGHT):
        yield np.einsum("au,bv,uvx->abx", across, along, control[flank].reshape(U, V, 3))


def areas(surface: Array) -> Array:
    """Areas (48, 120) of the patches."""
    both = np.cross(surface[1:, 1:] - surface[:-1, :-1], surface[1:, :-1] - surface[:-1, 1:])
    return np.asarray(0.5 * np.linalg.norm(both, axis=2))


def bends_deg(surface: Array) -> Array:
    """Angles (49, 119) between consecutive edges along the body."""
    edge = np.diff(surface, axis=1)
    edge /= np.maximum(np.linalg.norm(edge, axis=2, keepdims=True), 1e-12)
    cosine = (edge[:, 1:] * edge[:, :-1]).sum(axis=2)
    return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def distortion(name: str, way: CouplingMethod) -> tuple[float, float, float]:
    """Least and greatest relative area, and the greatest increase of an angle, degrees."""
    species, repertoire = load_species(name), read_repertoire(repertoire_file(name))
    nodes = repertoire.rest_nodes
    control = rest_control_points(
        species.surface, repertoire.body_length_cm, float(nodes[:, 0].max())
    )
    coupling = couple(way, nodes, control)
    rest = list(flanks(control))
    ratios, bends = [], []
    for segment in SEGMENTS:
        for points in place(coupling, repertoire.segments[segment].nodes):
            for before, surface in zip(rest, flanks(points), strict=True):
                ratios.append(areas(surface) / areas(before))
                bends.append(float((bends_deg(surface) - bends_deg(before)).max()))
    return float(np.min(ratios)), float(np.max(ratios)), max(bends)


def main() -> None:
    """Print a row for each kind of coupling."""
    names = sys.argv[1:] or ["fusilier", "emperor_angelfish"]
    print(f"{'':14s}" + "".join(f"{name:>30s}" for name in names))
    for way in get_args(CouplingMethod):
        print(f"{way:14s}", end="")
        for name in names:
            least, most, bend = distortion(name, way)
            print(f"{f'{least:.2f} to {most:.2f}, {bend:.1f} degrees':>30s}", end="")
        print()


if __name__ == "__main__":
    main()
