"""The mesh of a species, and each recorded segment as a clip of that mesh.

Points are as in `shaders/fishes.vert` with closed mouth, spread fins and relaxed paired fins, of a
typical adult: α times as large as the recorded fish and slower by √α, at the pace of its species,
as in playback.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.core.arrays import Array, Ints
from subsea.core.errors import UserError
from subsea.core.resources import is_path
from subsea.fish import sheet_layout
from subsea.fish.color_sheet import sheet_of
from subsea.fish.coupling import couple, place
from subsea.fish.mesh import (
    ABSENT,
    BODY,
    DETAILS,
    FIN,
    PECTORAL,
    PELVIC,
    Mesh,
    fish_mesh,
    species_vertices,
)
from subsea.fish.species import Species, load_species, own_species, repertoire_file
from subsea.fish.surface import CONTROL_POINTS, PaddlePlan, SurfacePlan, rest_control_points
from subsea.geometry.rotation import matrix, multiply, normalised
from subsea.repertoire import Repertoire, Segment, read_repertoire

SWEEP_RAD = 0.35  # of relaxed paired fins, away from the body
# From `shaders/fishes.vert`: spread of a wing, its part of the sweep, outward lean of a paddle.
WING_SPREAD, WING_BEAT, LEAN = 0.95, 0.2, 0.35
OPAQUE = 250  # of 255; less opaque texels are blended
ROUGHNESS = 0.45  # of a wet skin
FINS = (
    ("dorsal", FIN, 1.0),
    ("ventral", FIN, -1.0),
    ("pectoral_left", PECTORAL, -1.0),
    ("pectoral_right", PECTORAL, 1.0),
    ("pelvic_left", PELVIC, -1.0),
    ("pelvic_right", PELVIC, 1.0),
)
INSET = (4.0, 1.0)  # texels between a fin and the border of its frame on the sheet


class Model(NamedTuple):
    """The mesh of a species at rest: n vertices, those of the body before those of fins."""

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


class Clip(NamedTuple):
    """A recorded segment in T frames; a cyclic one ends in its first pose."""

    name: str
    fps: float
    cyclic: bool
    points: Array  # (T, n, 3) cm, body axes
    normals: Array  # (T, n, 3)
    position: Array  # (T, 3) cm, of the body frame; begins at the origin
    rotation: Array  # (T, 4) unit quaternions (w, x, y, z) of continuous sign; begins as identity


def make_clips(name: str, detail: int = 0) -> tuple[Model, list[Clip]]:
    """The mesh of a species at a level of detail, and a clip of each recorded segment.

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
    """Mesh and clips of a given species and repertoire."""
    length = float(np.mean(species.size_cm))
    scale = length / repertoire.body_length_cm
    rest = rest_control_points(
        species.surface, repertoire.body_length_cm, repertoire.rest_nodes[0, 0]
    )
    coupling = couple(species.surface.coupling, repertoire.rest_nodes, rest)
    surface = Surface(species.surface, repertoire.body_length_cm, detail)
    points, normals = surface.at(rest[None])
    triangles, body = _facing(surface.triangles, surface.body, points[0], normals[0])
    model = Model(
        name=name,
        length_cm=length,
        rest=scale * points[0],
        normals=normals[0],
        uv=surface.uv,
        triangles=triangles,
        body=body,
        solid=surface.solid,
        fins=surface.fins,
        sheet=sheet_of(species),
    )
    clips = []
    for segment in repertoire.recorded_names():
        one = repertoire.segments[segment]
        control = one.control_points
        points, normals = surface.at(place(coupling, one.nodes) if control is None else control)
        position, rotation = root_motion(one)
        if one.cyclic:
            points, normals = (np.concatenate([part, part[:1]]) for part in (points, normals))
        clips.append(
            Clip(
                name=segment,
                fps=species.pace / (repertoire.tick_s * np.sqrt(scale)),
                cyclic=one.cyclic,
                points=scale * points,
                normals=normals,
                position=scale * position,
                rotation=rotation,
            )
        )
    return model, clips


def root_motion(segment: Segment) -> tuple[Array, Array]:
    """Position (T, 3), cm, and attitude (T, 4) of each frame relative to the first.

    A row holds the step that leads to it; the first row closes a cycle (SMC eqs. 10 and 11).
    """
    rows = [*range(1, len(segment.nodes)), *([0] if segment.cyclic else [])]
    position, rotation = [np.zeros(3)], [np.array([1.0, 0.0, 0.0, 0.0])]
    for row in rows:
        before = rotation[-1]
        position.append(position[-1] + matrix(before) @ segment.increment_translation[row])
        after = np.array(normalised(multiply(before, segment.increment_rotation[row])))
        rotation.append(after if after @ before > 0 else -after)
    return np.array(position), np.array(rotation)


def first_frames(clips: list[Clip]) -> list[int]:
    """The number of each clip's first frame, when all clips follow one another."""
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
    """Which triangles (m,) show texels that are not opaque."""
    height, width = model.sheet.shape[:2]
    corners = model.uv[model.triangles]  # (m, 3, 2)
    weights = np.array([(i, j, 4 - i - j) for i in range(5) for j in range(5 - i)]) / 4.0
    at = (weights @ corners) * (width, height)  # (m, 15, 2)
    column = at[..., 0].astype(int).clip(0, width - 1)
    row = at[..., 1].astype(int).clip(0, height - 1)
    return np.asarray((model.sheet[row, column, 3] < OPAQUE).any(axis=1))


class Surface:
    """The drawn surface of a species at a level of detail, without missing fins."""

    def __init__(self, plan: SurfacePlan, length_cm: float, detail: int) -> None:
        mesh = fish_mesh(DETAILS[detail])
        own = species_vertices(plan, mesh, DETAILS[detail])
        exists = own[:, 2] != ABSENT
        number = np.cumsum(exists) - 1
        once = mesh.triangles[: mesh.body + mesh.fins]
        has = exists[once].all(axis=1)
        self.triangles = number[once[has]].astype(np.int32)
        self.body = int(has[: mesh.body].sum())
        self.uv = _texture_coordinates(plan, mesh, own)[exists]
        part, side = mesh.vertices[exists, 12], mesh.vertices[exists, 14]
        self.solid = int((part == BODY).sum())
        self._outward = np.where(part == BODY, -side, 1.0)
        splines = part <= FIN
        self._splines = int(splines.sum())
        base = own[exists, 2].astype(int)
        rows = mesh.vertices[exists][splines]
        # Weights (n, 426) of the control points, and their slopes across and along.
        self._place, self._across, self._along = (
            _weights(rows, base[splines], u, v) for u, v in ((0, 3), (6, 3), (0, 9))
        )
        self._paddles = [
            (paddle, sign, mine, base[mine], length_cm * own[exists][mine, :2])
            for paddle, number in ((plan.pectoral, PECTORAL), (plan.pelvic, PELVIC))
            for sign in (-1.0, 1.0)
            if paddle and (mine := (part == number) & (side == sign)).any()
        ]
        self._along_share = mesh.vertices[exists, 13]
        self.fins = {
            name: np.flatnonzero((part == number) & (side == sign))
            for name, number, sign in FINS
            if ((part == number) & (side == sign)).any()
        }

    def at(self, control: Array) -> tuple[Array, Array]:
        """Points and normals (T, n, 3) for control points (T, 426, 3)."""
        control = np.asarray(control, np.float64)
        points = np.empty((len(control), len(self.uv), 3))
        u, v = np.empty_like(points), np.empty_like(points)
        n = self._splines
        for out, weights in ((points, self._place), (u, self._across), (v, self._along)):
            out[:, :n] = np.swapaxes(np.tensordot(weights, control, (1, 1)), 0, 1)
        for paddle, side, mine, base, outline in self._paddles:
            u[:, mine], v[:, mine] = _paddle_axes(paddle, side, self._along_share[mine])
            back, across = outline[:, :1] * u[0, mine], outline[:, 1:] * v[0, mine]
            points[:, mine] = control[:, base] + back + across
        normals = np.cross(u, v)
        size = np.linalg.norm(normals, axis=2, keepdims=True)
        # At the snout all control points of a row coincide: the normal points ahead.
        sound = size**2 > 1e-8
        normals = np.where(sound, normals / np.where(sound, size, 1.0), (1.0, 0.0, 0.0))
        return points, normals * self._outward[:, None]


def _weights(vertices: Array, base: Ints, u: int, v: int) -> Array:
    """Weights (n, 426) of the control points; vertex columns `u` and `v` hold the taps."""
    tap = np.arange(3)
    stride = vertices[:, 15].astype(int)[:, None, None]
    points = base[:, None, None] + tap[:, None] * stride + tap
    weight = vertices[:, u : u + 3, None].astype(float) * vertices[:, None, v : v + 3]
    out = np.zeros((len(vertices), CONTROL_POINTS))
    # The third row of a linear patch has weight zero and may be beyond the last point.
    row = np.broadcast_to(np.arange(len(vertices))[:, None, None], points.shape)
    np.add.at(out, (row, np.minimum(points, CONTROL_POINTS - 1)), weight)
    return out


def _paddle_axes(plan: PaddlePlan, side: float, along: Array) -> tuple[Array, Array]:
    """Directions (n, 3) along and across a relaxed paired fin, at fractions (n,) of its length."""
    droop = np.radians(plan.droop)
    beat = SWEEP_RAD * (0.6 + 0.55 * along[:, None])
    bend = WING_SPREAD + WING_BEAT * beat if plan.wing else beat
    back = np.array([-np.cos(droop), -np.sin(droop), 0.0])
    across = np.array([1.0, 0.0, 0.0]) if plan.wing else np.array([back[1], -back[0], LEAN * side])
    back = back * np.cos(bend) + np.array([0.0, 0.0, side]) * np.sin(bend)
    return back, np.broadcast_to(across / np.linalg.norm(across), back.shape)


def _texture_coordinates(plan: SurfacePlan, mesh: Mesh, own: Array) -> Array:
    """Texture coordinates (n, 2) of all vertices of a level."""
    part, side, along = mesh.vertices[:, 12], mesh.vertices[:, 14], mesh.vertices[:, 13]
    (front, rear), top = sheet_layout.borders(plan), sheet_layout.half_height(plan)
    body = (own[:, :2] - (front, -top)) / (rear - front, 2.0 * top)
    fin, paddle = np.stack([own[:, 3], along], 1), np.stack([along, own[:, 3]], 1)
    inset = np.array(INSET) / sheet_layout.SIZE
    out = np.zeros((len(own), 2))
    for frame, mine, within, gap in (
        (sheet_layout.BODY, part == BODY, np.clip(body, 0.0, 1.0), 0.0),
        (sheet_layout.DORSAL, (part == FIN) & (side > 0), fin, inset),
        (sheet_layout.VENTRAL, (part == FIN) & (side < 0), fin, inset),
        (sheet_layout.PECTORAL, part == PECTORAL, paddle, inset),
        (sheet_layout.PELVIC, part == PELVIC, paddle, inset),
    ):
        low, high = np.array(frame[:2]) + gap, np.array(frame[2:]) - gap
        out[mine] = low + within[mine] * (high - low)
    return out


def _facing(triangles: Ints, body: int, points: Array, normals: Array) -> tuple[Ints, int]:
    """Turn fin triangles to the side of their normals and drop degenerate ones.

    Return also the number of the body's.
    """
    a, b, c = (points[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    turned = (across * normals[triangles].sum(axis=1)).sum(axis=1) < 0.0
    turned[:body] = False
    kept = (across**2).sum(axis=1) > 1e-16 * np.ptp(points[:, 0]) ** 4
    facing = np.where(turned[:, None], triangles[:, ::-1], triangles)
    return facing[kept], int(kept[:body].sum())
