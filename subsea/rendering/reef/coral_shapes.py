"""Shapes of corals, sponges and anemones: meshes of size 1 at five levels of detail.

The number of a variant seeds it, so its levels are of one growth: coarser ones leave small parts
out and make the others thicker.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np

from subsea.habitat.reef import KINDS
from subsea.rendering.reef.branching_corals import bush, fan, finger, rubble, soft, staghorn
from subsea.rendering.reef.coral_mesh import CoralMesh, Rng, fitted, single, turned
from subsea.rendering.reef.massive_corals import brain, leather, lettuce, mound, table
from subsea.rendering.reef.sponges import anemone, barrel, pipes

LEVELS = 5  # the last is a mere lump
SMOOTH = ("mound", "brain", "barrel", "leather", "table", "lettuce")
SHAPES: dict[str, Callable[[Rng, int], CoralMesh]] = {
    "staghorn": staghorn, "bush": bush, "table": table, "brain": brain, "lettuce": lettuce,
    "finger": finger, "leather": leather, "soft": soft, "fan": fan, "pipes": pipes,
    "barrel": barrel, "anemone": anemone, "rubble": rubble,
    "mound": mound,
}  # fmt: skip


def lump(kind: str, mesh: CoralMesh) -> CoralMesh:
    """A few triangles as wide at each height, and as ragged, as a mesh."""
    x, y, z = mesh.place.T
    flat, top = (0.1 if kind == "fan" else 1.0), z.max()
    columns = 7
    ragged = np.random.default_rng(len(mesh.place)).uniform(0.6, 1.0, columns + 1)
    ragged = 0.5 + 0.5 * ragged if kind in SMOOTH else ragged
    ragged[-1] = ragged[0]
    share = np.array([0.0, 0.5, 0.85, 1.0] if kind in SMOOTH else [0.0, 0.55, 1.0])
    height = top * share
    wide = [np.hypot(x, y)[np.abs(z - h) < 0.3 * top].max(initial=0.1) for h in height[:2]]
    if kind in SMOOTH:
        wide.append(0.6 * wide[1])
    reach = np.array([*wide, 0.0])[:, None] * ragged
    rise = height[:, None] * (1.0 + 0.25 * (ragged - 1.0))
    rise[1] += 0.4 * top * (ragged[::-1] - 0.8)
    dark = 0.7 if kind == "table" else 0.35
    light = np.interp(share, [0.0, 0.55, 1.0], [dark, 0.85, 0.8])[:, None]
    tip = np.interp(share, [0.0, 0.55, 1.0], [0.1, 0.6, 0.5])[:, None] * ragged
    out = turned(reach, np.maximum(rise, 0.0), tip=tip, light=light)
    return out._replace(place=out.place * (1.0, flat, 1.0))


def forms(wanted: Sequence[tuple[str, int]]) -> list[list[CoralMesh]]:
    """All levels of kinds and variants, finest first, in single precision."""

    def levels(one: tuple[str, int]) -> list[CoralMesh]:
        return [single(shape(*one, level)) for level in range(LEVELS)]

    with ThreadPoolExecutor() as pool:  # numpy releases the GIL
        return list(pool.map(levels, wanted))


@cache
def shape(kind: str, variant: int, level: int) -> CoralMesh:
    """One variant of a kind at one level, with the proportions of `habitat.reef.KINDS`."""
    if level == LEVELS - 1:
        before = shape(kind, variant, level - 1)
        last = fitted(lump(kind, before), KINDS[kind].height)
        return last if len(last.triangles) < len(before.triangles) else before
    rng = np.random.default_rng([variant, 0xC0, list(SHAPES).index(kind)])
    if kind == "mound":  # not fitted: other growths stand on this surface
        return mound(rng, level, variant)
    return fitted(SHAPES[kind](rng, level), KINDS[kind].height)
