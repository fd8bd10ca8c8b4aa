"""The document of the skin editor: a photograph, a species, and meshes between them."""

from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np

from subsea.base.arrays import Bools, Bytes
from subsea.fish.color_sheet import sheet_of
from subsea.fish.species import Species, load_species
from subsea.studio import mesh_edit
from subsea.studio.deformable_mesh import (
    DEFAULT,
    EdgeField,
    FishMeshes,
    MeshParameters,
    copy_meshes,
    edge_field,
    step,
    transform,
)
from subsea.studio.dress import load_mesh
from subsea.studio.fitting import fin_errors, outline_error, segment_under
from subsea.studio.lift import lift_sheet
from subsea.studio.mesh_edit import MeshSnapshot
from subsea.studio.photograph import Photograph, downscale
from subsea.studio.side_view import centred_matrix, make_fish_meshes, side_view
from subsea.ui.undo import History

STEPS = 5  # of the mesh simulation in a frame: slow enough to watch
STILL = 0.01  # pixels a step: at rest
MOST_STEPS = 4000  # two outlines may pull at one node for ever


class MeshSliders(NamedTuple):
    """Settings of the mesh panel."""

    tension: float = DEFAULT.tension
    rigidity: float = DEFAULT.rigidity
    picture: float = DEFAULT.picture
    smoothing: float = 1.8  # σ, pixels of the small picture
    found: bool = True  # use the outline of the fish that was found, not all edges
    reach: float = 0.15  # of a drag, body lengths


class SkinDocument:
    """The state of the skin editor, without a window.

    Meshes are in pixels of a small picture, for which the default forces are made; `to_photo`
    and `from_photo` convert.
    """

    def __init__(self, photograph: Photograph, name: str, flip: bool = False) -> None:
        """Begin with the meshes of a species in the middle of the photograph."""
        self.photograph = photograph
        self.colour, self._scale = downscale(photograph)
        self.sliders = MeshSliders()
        self.relaxing = False
        self.from_file = False  # meshes of a file show where the fish is
        self.fish: Bools | None = None  # mask of the present meshes in the photograph, if known
        self.sheet_outdated = True
        self.search: object | None = None  # identifies the search whose result is still wanted
        self.error: float | None = None  # of the outline, body lengths
        self.fin_errors: dict[str, float] = {}  # of the roots of fins, body lengths
        self._steps = 0
        self.mask: Bools | None = None  # the fish that was found, in the small picture
        self._field: EdgeField | None = None
        self._field_key: tuple[float, bool] | None = None
        self.set_species(name)
        self.sheet = self.painted_sheet
        self.meshes = self.initial_meshes()
        if flip:
            self.meshes = mesh_edit.flip(self.meshes)
        self.history: History[MeshSnapshot] = History(self._snapshot())

    def set_species(self, name: str) -> None:
        """Load a species; on a UserError nothing changes."""
        species = load_species(name)
        rest, painted = side_view(species.surface), sheet_of(species)
        self.name, self.species, self.rest, self.painted_sheet = name, species, rest, painted

    def initial_meshes(self) -> FishMeshes:
        """Return meshes of the species' own shape in the middle of the photograph."""
        height, width = self.colour.shape[:2]
        matrix = centred_matrix(width, height, self.species.surface)
        return make_fish_meshes(self.species.surface, matrix)

    def load_mesh(self, path: Path) -> None:
        """Take the meshes of a file."""
        meshes = self.from_photo(load_mesh(path, self.photograph, self.species))
        self.relax(False)
        self.meshes, self.from_file = meshes, True

    def begin_history(self) -> None:
        """Make the present meshes the first state, which counts as saved."""
        self.history, self.sheet_outdated = History(self._snapshot()), True

    def record(self) -> None:
        """Add the present meshes to the undo history; a search in progress is obsolete then."""
        self.history.do(self._snapshot())
        self.sheet_outdated, self.fish, self.search = True, None, None

    def restore(self, meshes: FishMeshes) -> None:
        """Show meshes of the undo history."""
        self.relaxing = False
        self.meshes = copy_meshes(meshes)
        self.sheet_outdated, self.fish = True, None

    def flip(self) -> None:
        """Turn the fish to the other side."""
        self.relaxing = False
        self.meshes = mesh_edit.flip(self.meshes)
        self.record()

    def relax(self, on: bool) -> None:
        """Start or stop the simulation of the meshes."""
        if self.relaxing and not on:
            self.record()
        self.relaxing, self._steps = on, 0

    def simulate(self, dragging: bool) -> str:
        """Make the steps of a frame; return a message if the simulation has ended."""
        if not self.relaxing:
            return ""
        moved = step(self.meshes, self.field, mesh_edit.stable_parameters(self.parameters), STEPS)
        self._steps += STEPS
        if dragging or (moved >= STILL and self._steps <= MOST_STEPS):
            return ""
        self.relax(False)
        if moved < STILL:
            return "The mesh has come to rest."
        return "The mesh does not come to rest: two outlines pull at it. Anchors may help."

    def to_photo(self, meshes: FishMeshes) -> FishMeshes:
        """Convert meshes from the small picture to the photograph."""
        return _scaled(meshes, 1.0 / self._scale)

    def from_photo(self, meshes: FishMeshes) -> FishMeshes:
        """Convert meshes from the photograph to the small picture."""
        return _scaled(meshes, self._scale)

    @property
    def parameters(self) -> MeshParameters:
        """The forces, as the sliders set them."""
        tension, rigidity, picture, *_ = self.sliders
        return DEFAULT._replace(tension=tension, rigidity=rigidity, picture=picture)

    @property
    def reach(self) -> float:
        """The reach of a drag, pixels."""
        row = self.meshes.body.nodes[len(self.meshes.body.nodes) // 2]
        return self.sliders.reach * float(np.hypot(*(row[0] - row[-1])))

    @property
    def field(self) -> EdgeField:
        """The edge field of the photograph, as the sliders set it."""
        mask = self.mask if self.sliders.found else None
        key = self.sliders.smoothing, mask is not None
        if self._field is None or key != self._field_key:
            picture: Any = self.colour if mask is None else mask
            self._field, self._field_key = edge_field(picture, self.sliders.smoothing), key
        return self._field

    def set_fish(self, mask: Bools) -> None:
        """Take a mask of the photograph as the fish that was found."""
        size = self.colour.shape[1::-1]
        share = cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA)
        self.mask, self._field = np.asarray(share > 0.5), None

    def set_sheet(self, sheet: Bytes, mask: Bools) -> None:
        """Take the sheet that was lifted through the meshes, and the mask of the fish there."""
        if self.mask is None and self.from_file:
            self.set_fish(mask)
        if self.mask is not None:
            self.error = outline_error(self.meshes, self.mask)
            self.fin_errors = fin_errors(self.meshes, self.species.surface)
        self.sheet = sheet

    def _snapshot(self) -> MeshSnapshot:
        return MeshSnapshot(self.name, copy_meshes(self.meshes))


def lift_from(
    photograph: Photograph, meshes: FishMeshes, species: Species, fish: Bools | None
) -> tuple[Bytes, Bools]:
    """Return the sheet under meshes, and the mask of the fish: `fish`, or found there."""
    mask = segment_under(photograph, meshes) if fish is None else fish
    return lift_sheet(photograph.colour, meshes, species, mask), mask


def _scaled(meshes: FishMeshes, scale: float) -> FishMeshes:
    """Copy meshes to a picture of another scale; middles of pixels are at whole numbers."""
    other, middle = copy_meshes(meshes), np.full(2, 0.5 * scale - 0.5)
    transform(other, np.eye(2) * scale, np.zeros(2), middle)
    for mesh in other.parts.values():
        mesh.anchors[:] = mesh.anchors * scale + middle
    return other
