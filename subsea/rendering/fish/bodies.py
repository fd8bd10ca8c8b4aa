"""The vertices of fishes as they are drawn, and how opaque their skin is there."""

from typing import NamedTuple

import numpy as np
from PIL import Image, ImageFilter

from subsea.base.arrays import Array, Ints
from subsea.fish.color_sheet import sheets
from subsea.fish.mesh import DETAILS, fish_mesh
from subsea.fish.species import Species
from subsea.frame.packet import KIND, Packet
from subsea.rendering.fish.atlas import side_by_side
from subsea.rendering.fish.fishes import DrawnVertices, FishShape

AROUND = 10  # texels, half of the way from one vertex to the next


class Shapes:
    """The vertices of all levels of detail of the species of a world."""

    def __init__(self, species: tuple[Species, ...], length_cm: tuple[float, ...]) -> None:
        """Prepare the shader for all levels."""
        self.skins = Skins(species)
        self._levels = [FishShape(species, length_cm, level) for level in range(len(DETAILS))]
        meshes = [fish_mesh(detail) for detail in DETAILS]
        # Without the back sides of fins, which have the same vertices.
        self.triangles = [mesh.triangles[: mesh.body + mesh.fins] for mesh in meshes]

    def at(self, level: int, instances: Array, control_points: Array) -> "Vertices":
        """Compute the vertices of instances (n, 30)."""
        shape, kinds = self._levels[level], instances[:, KIND].astype(int)
        drawn = shape.at(instances, control_points)
        opacity = np.where(shape.present[kinds], self.skins.opacity(kinds, drawn), np.nan)
        return Vertices(drawn.places.astype(np.float64), opacity)


class Vertices(NamedTuple):
    """The m vertices of n bodies."""

    places: Array  # (n, m, 3) cm, world
    opacity: Array  # (n, m) of the skin, 0 to 1; NaN for fins that the species lacks


class Skins:
    """The opacity of the skins of species, which the fins' edges lack."""

    def __init__(self, species: tuple[Species, ...]) -> None:
        """Paint the skins, or read them from the disk."""
        mean = ImageFilter.BoxBlur(AROUND)
        alphas = [side_by_side([sheet])[..., 3] for sheet in sheets(species)]
        self._mean = [np.asarray(Image.fromarray(one).filter(mean)) for one in alphas]

    def opacity(self, kinds: Ints, drawn: DrawnVertices) -> Array:
        """Look up the mean opacity (n, m) around vertices of fishes of the species `kinds` (n,)."""
        out = np.empty(drawn.skin.shape[:2])
        for kind in np.unique(kinds):
            sheet = self._mean[kind]
            limit = np.array(sheet.shape[::-1])
            place = (drawn.skin[kinds == kind] * limit).astype(np.int64)
            column, row = np.moveaxis(np.clip(place, 0, limit - 1), -1, 0)
            out[kinds == kind] = sheet[row, column] / 255.0
        return out


def levels_of(packet: Packet) -> Ints:
    """The level of detail (n,) of each instance of the first view; specks have the coarsest."""
    levels = np.zeros(len(packet.instances), np.int64)
    for batch in packet.batches[0]:
        levels[batch.first : batch.first + batch.count] = min(batch.level, len(DETAILS) - 1)
    return levels
