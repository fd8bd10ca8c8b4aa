"""The mesh of a species, and each recorded segment as a clip of that mesh.

`shaders/fishes.vert` computes the points. They are of a typical adult: α times as large as the
recorded fish and slower by √α, at the pace of its species, as in playback.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Bytes, Ints
from subsea.base.errors import UserError
from subsea.base.system import is_path
from subsea.export.fin_motion import FinPlayer
from subsea.export.scale_relief import scale_normals
from subsea.fish.color_sheet import sheet_of
from subsea.fish.forms import couple_surface, lay
from subsea.fish.mesh import (
    ABSENT,
    BODY,
    DETAILS,
    FIN,
    PECTORAL,
    PELVIC,
    fish_mesh,
    species_vertices,
)
from subsea.fish.skinning import place
from subsea.fish.species import Species, load_species, own_species, repertoire_file
from subsea.fish.surface import CONTROL_POINTS, rest_control_points
from subsea.frame.packet import (
    FINS,
    IDENTITY,
    KIND,
    ORIENTATION,
    POSITION,
    ROW_A,
    ROW_B,
    resting_instances,
)
from subsea.geometry.rotation import matrix, multiply, normalised
from subsea.rendering.fish.atlas import on_sheet
from subsea.rendering.fish.fishes import FishShape
from subsea.rendering.fish.preview import without_variation
from subsea.repertoire import Repertoire, Segment, read_repertoire

OPAQUE = 250  # of 255; less opaque texels are blended
UNTURNED = (1.0, 0.0, 0.0, 0.0)
FIN_NAMES = {  # part and side of a vertex
    "dorsal": (FIN, 1.0),
    "ventral": (FIN, -1.0),
    "pectoral_left": (PECTORAL, -1.0),
    "pectoral_right": (PECTORAL, 1.0),
    "pelvic_left": (PELVIC, -1.0),
    "pelvic_right": (PELVIC, 1.0),
}


class Model(NamedTuple):
    """The mesh of a species at rest: n vertices, first of the body, then of fins."""

    name: str  # of its file
    length_cm: float
    rest: Array  # (n, 3) cm, body axes: x anterior, y dorsal, z right
    normals: Array  # (n, 3)
    uv: Array  # (n, 2) texture coordinates, from the lower left corner
    triangles: Ints  # (m, 3) int32, counter-clockwise from outside; fins have one side
    body: int  # number of triangles of the body, which come first ...
    solid: int  # ... and of its vertices
    fins: Mapping[str, Ints]  # vertices of the existing fins: dorsal, pectoral_left, …
    sheet: NDArray[np.uint8]  # (h, w, 4) sRGB and opacity, bottom row first
    gloss: float  # reflectance of the scales, 0 to 1 ...
    silver: float  # ... and of pale parts of the flanks
    scales: Bytes | None = None  # (h, w, 3) normal map of the body, bottom row first


class Clip(NamedTuple):
    """A recorded segment in T frames. A cyclic segment ends in its first pose."""

    name: str
    fps: float
    cyclic: bool
    points: Array  # (T, n, 3) cm, body axes
    normals: Array  # (T, n, 3)
    position: Array  # (T, 3) cm, of the body frame; begins at the origin
    rotation: Array  # (T, 4) unit quaternions (w, x, y, z) of continuous sign; begins as identity
    beats: int  # of the tail, in a cyclic segment


class Surface:
    """The drawn surface of a species at a level of detail, without missing fins: n vertices."""

    def __init__(self, species: Species, length_cm: float, detail: int) -> None:
        """Prepare the surface of a recorded fish of this length; UserError without OpenGL."""
        mesh = fish_mesh(DETAILS[detail])
        self._exists = species_vertices(species.surface, mesh, DETAILS[detail])[:, 2] != ABSENT
        number = np.cumsum(self._exists) - 1
        once = mesh.triangles[: mesh.body + mesh.fins]
        has = self._exists[once].all(axis=1)
        self.triangles = number[once[has]].astype(np.int32)
        self.body = int(has[: mesh.body].sum())
        part, side = mesh.vertices[self._exists, 12], mesh.vertices[self._exists, 14]
        self.solid = int((part == BODY).sum())
        self.fins = {
            name: np.flatnonzero((part == kind) & (side == sign))
            for name, (kind, sign) in FIN_NAMES.items()
            if ((part == kind) & (side == sign)).any()
        }
        self._shape = FishShape((species,), (length_cm,), detail)
        alike = FishShape((without_variation(species),), (length_cm,), detail)
        skin = alike.at(resting_instances(1), np.zeros((1, CONTROL_POINTS, 3))).skin[0]
        self.uv = on_sheet(skin[self._exists].astype(np.float64))

    def at(self, control: Array, fins: Array | None = None) -> tuple[Array, Array]:
        """Compute points and normals (T, n, 3) for control points (T, 426, 3).

        `fins` (T, 14) are as in `state.Fishes`; None: at ease, with the mouth shut.
        """
        rows = resting_instances(len(control))
        rows[:, ROW_A] = rows[:, ROW_B] = np.arange(len(control))
        if fins is not None:
            rows[:, FINS] = fins
        return self.drawn(rows, control)

    def drawn(self, instances: Array, control_points: Array) -> tuple[Array, Array]:
        """Compute points and normals (T, n, 3) of instances (T, 30), in body axes.

        Their poses are rows of `control_points` (rows, 426, 3). Points have the fish's own size.
        """
        rows = np.array(instances, np.float32)
        rows[:, POSITION], rows[:, ORIENTATION], rows[:, KIND] = 0.0, UNTURNED, 0.0
        shown = self._shape.at(rows, control_points)
        # Single precision is too coarse for the sums over frames of what follows.
        places = shown.places[:, self._exists].astype(np.float64)
        return places, shown.normals[:, self._exists].astype(np.float64)

    def tints(self, identities: Array) -> Array:
        """Compute factors (k, 3) of the colours of fishes, which tell them from each other."""
        rows = resting_instances(len(identities))
        rows[:, IDENTITY] = identities
        tone = self._shape.at(rows, np.zeros((1, CONTROL_POINTS, 3))).tone
        return np.asarray(tone[:, 0, :3], np.float64)


def make_clips(name: str, detail: int = 0) -> tuple[Model, list[Clip]]:
    """Make the mesh of a species at a level of detail, and a clip of each recorded segment.

    UserError for an unknown species, a path, or a faulty repertoire.
    """
    if is_path(name, ".toml"):  # it has no known repertoire
        raise UserError(f"{name}: expected the name of a species; your own are in {own_species()}")
    species = load_species(name)
    path = repertoire_file(name)
    if not path.is_file():
        raise UserError(f"no such file; run `subsea-capture record {name}`", file=path)
    repertoire = read_repertoire(path)
    if repertoire.species != name:
        raise UserError(f"holds {repertoire.species!r}, expected {name!r}", file=path)
    return clips_of(name, species, repertoire, detail)


def clips_of(
    name: str, species: Species, repertoire: Repertoire, detail: int
) -> tuple[Model, list[Clip]]:
    """Make mesh and clips of a given species and repertoire."""
    size, snout = repertoire.body_length_cm, float(repertoire.rest_nodes[0, 0])
    model, surface = model_of(name, species, size, snout, detail)
    scale = model.length_cm / size
    coupling = couple_surface(species.form, species.surface, size, repertoire.rest_nodes)
    fins = FinPlayer(species, repertoire, scale)
    clips = []
    for segment in repertoire.recorded_names():
        recorded = repertoire.segments[segment]
        control = recorded.control_points
        control = place(coupling, recorded.nodes) if control is None else control
        beats, moved = fins.clip(segment)
        shown = np.arange(len(moved)) % len(control)
        points, normals = surface.at(control[shown], moved)
        if recorded.cyclic:
            points[-1], normals[-1] = points[0], normals[0]
        position, rotation = root_motion(recorded, beats)
        clips.append(
            Clip(
                name=segment,
                fps=species.pace / (repertoire.tick_s * np.sqrt(scale)),
                cyclic=recorded.cyclic,
                points=scale * points,
                normals=normals,
                position=scale * position,
                rotation=rotation,
                beats=beats,
            )
        )
    return model, clips


def model_of(
    name: str, species: Species, recorded_cm: float, snout_cm: float, detail: int
) -> tuple[Model, Surface]:
    """Make the mesh of a typical adult at rest, and the surface of the recorded fish.

    `recorded_cm` is the length of the recorded fish, `snout_cm` the x of its snout at rest.
    """
    length = float(np.mean(species.size_cm))
    surface = Surface(species, recorded_cm, detail)
    rest = rest_control_points(species.surface, recorded_cm, snout_cm)
    rest = lay(rest) if species.form == "flatfish" else rest
    points, normals = surface.at(rest[None])
    triangles, body = _facing(surface.triangles, surface.body, points[0], normals[0])
    model = Model(
        name=name,
        length_cm=length,
        rest=length / recorded_cm * points[0],
        normals=normals[0],
        uv=surface.uv,
        triangles=triangles,
        body=body,
        solid=surface.solid,
        fins=surface.fins,
        sheet=sheet_of(species),
        gloss=species.skin.gloss,
        silver=species.skin.silver,
        scales=scale_normals(species),
    )
    return model, surface


def root_motion(segment: Segment, beats: int = 1) -> tuple[Array, Array]:
    """Compute position (T, 3), cm, and attitude (T, 4) of each frame relative to the first.

    A cyclic segment is repeated for a number of beats.

    A row holds the step that leads to it; the first row closes a cycle (SMC eqs. 10 and 11).
    """
    rows = [*range(1, len(segment.nodes)), *([0] if segment.cyclic else [])] * beats
    position, rotation = [np.zeros(3)], [np.array([1.0, 0.0, 0.0, 0.0])]
    for row in rows:
        before = rotation[-1]
        position.append(position[-1] + matrix(before) @ segment.increment_translation[row])
        step = tuple(segment.increment_rotation[row])
        after = np.array(normalised(multiply(tuple(before), step)))
        rotation.append(after if after @ before > 0 else -after)
    return np.array(position), np.array(rotation)


def at_rate(clip: Clip, fps: float) -> Clip:
    """Resample a clip to another number of frames per second.

    It lasts a whole number of frames: it is played faster or slower by half a frame at most, so
    that a cycle still ends as it begins.
    """
    count = max(round((len(clip.points) - 1) * fps / clip.fps), 1)
    at = np.linspace(0.0, len(clip.points) - 1.0, count + 1)
    first = np.minimum(at.astype(int), len(clip.points) - 2)
    share = at - first

    def between(values: Array) -> Array:
        weight = share.reshape(-1, *[1] * (values.ndim - 1))
        return np.asarray(values[first] + weight * (values[first + 1] - values[first]))

    normals, rotation = between(clip.normals), between(clip.rotation)
    return clip._replace(
        fps=fps,
        points=between(clip.points),
        normals=normals / np.linalg.norm(normals, axis=2, keepdims=True),
        position=between(clip.position),
        rotation=rotation / np.linalg.norm(rotation, axis=1, keepdims=True),
    )


def all_points(clips: list[Clip]) -> Array:
    """Return the points (F, n, 3) of all clips, which follow each other."""
    return np.concatenate([clip.points for clip in clips])


def first_frames(clips: list[Clip]) -> list[int]:
    """Number the first frame of each clip, when all clips follow each other."""
    return np.cumsum([0, *(len(clip.points) for clip in clips[:-1])]).tolist()


def transform_points(points: Array, position: Array, rotation: Array) -> Array:
    """Move points (T, n, 3) from body axes to the axes of a root (T, 3), (T, 4)."""
    return np.asarray(position[:, None] + points @ np.swapaxes(matrix(rotation), 1, 2))


def bake_root(clip: Clip) -> Clip:
    """Move the motion of the root into the points; the root stands still."""
    still, upright = np.zeros_like(clip.position), np.zeros_like(clip.rotation)
    upright[:, 0] = 1.0
    return clip._replace(
        points=transform_points(clip.points, clip.position, clip.rotation),
        normals=transform_points(clip.normals, still, clip.rotation),
        position=still,
        rotation=upright,
    )


def transparent_triangles(model: Model) -> NDArray[np.bool_]:
    """Find the triangles (m,) that show texels which are not opaque."""
    height, width = model.sheet.shape[:2]
    corners = model.uv[model.triangles]  # (m, 3, 2)
    weights = np.array([(i, j, 4 - i - j) for i in range(5) for j in range(5 - i)]) / 4.0
    at = (weights @ corners) * (width, height)  # (m, 15, 2)
    column = at[..., 0].astype(int).clip(0, width - 1)
    row = at[..., 1].astype(int).clip(0, height - 1)
    return np.asarray((model.sheet[row, column, 3] < OPAQUE).any(axis=1))


def turned_to_normals(triangles: Ints, points: Array, normals: Array) -> Ints:
    """Turn triangles (m, 3) to the side of the normals (n, 3) of their corners."""
    turned = (_across(triangles, points) * normals[triangles].sum(axis=1)).sum(axis=1) < 0.0
    return np.where(turned[:, None], triangles[:, ::-1], triangles).astype(np.int32)


def _across(triangles: Ints, points: Array) -> Array:
    """Compute a normal (m, 3) of each triangle, twice as long as its area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def _facing(triangles: Ints, body: int, points: Array, normals: Array) -> tuple[Ints, int]:
    """Turn fin triangles to the side of their normals and drop degenerate ones.

    Return also the number of those of the body.
    """
    kept = (_across(triangles, points) ** 2).sum(axis=1) > 1e-16 * np.ptp(points[:, 0]) ** 4
    fins = turned_to_normals(triangles[body:], points, normals)
    return np.concatenate([triangles[:body], fins])[kept], int(kept[:body].sum())
