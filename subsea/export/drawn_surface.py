"""The drawn surface of a fish in numpy, with moving fins and mouth, as in `shaders/fishes.vert`."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.fish import sheet_layout
from subsea.fish.face import jaws
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
from subsea.fish.species import Species
from subsea.fish.surface import CONTROL_POINTS, PaddlePlan, SurfacePlan

SWEEP_RAD = 0.35  # of relaxed paired fins, away from the body; of pelvic fins always
# As `state.Fishes.fins`: left and right sweep, left and right lift, rad; mouth; dorsal fin; tail.
AT_EASE = (SWEEP_RAD, SWEEP_RAD, 0.0, 0.0, 0.0, 1.0, 0.0)
LEFT_SWEEP, LEFT_LIFT, MOUTH, FOLD, TAIL = 0, 2, 4, 5, 6
# From `shaders/fishes.vert`: spread of a wing, its part of the sweep, outward lean of a paddle.
WING_SPREAD, WING_BEAT, LEAN = 0.95, 0.2, 0.35
BEHIND, JOINT = 3.0, 0.25  # of the mouth, in its lengths: nothing moves behind; joint of the jaws
LIFT = 0.4  # of `shaders/mouth.glsl`
FINS = (
    ("dorsal", FIN, 1.0),
    ("ventral", FIN, -1.0),
    ("pectoral_left", PECTORAL, -1.0),
    ("pectoral_right", PECTORAL, 1.0),
    ("pelvic_left", PELVIC, -1.0),
    ("pelvic_right", PELVIC, 1.0),
)
INSET = (4.0, 1.0)  # texels between a fin and the border of its frame on the sheet


class _Paddle(NamedTuple):
    """A paired fin."""

    plan: PaddlePlan
    side: float  # -1 left, 1 right
    moves: bool  # as pectoral fins do
    mine: Bools  # (n,) True for its vertices
    base: Ints  # (k,) control point at its root
    outline: Array  # (k, 2) cm, along and across
    along: Array  # (k,) share of its length


class _Jaws(NamedTuple):
    """The k vertices near the mouth, and how each of them moves."""

    mine: Ints  # (k,)
    opening_rad: float  # of the lower jaw
    share: Array  # (k,) of that angle by which each turns upward
    arm: Array  # (k, 2) cm, from the joint, forward and up
    pull: Array  # (k,) cm for each radian, by which skin between the jaws is drawn in


class Surface:
    """The drawn surface of a species at a level of detail, without missing fins."""

    def __init__(self, species: Species, length_cm: float, detail: int) -> None:
        plan = species.surface
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
            _weights(rows[:, u : u + 3], rows[:, v : v + 3], rows[:, 15], base[splines])
            for u, v in ((0, 3), (6, 3), (0, 9))
        )
        rest = own[exists, :2]
        stiff = float(plan.stiff_fins)
        # The share by which the tail spreads each vertex; the vertices of fins, and their roots.
        self._spread = np.where(part == BODY, _smooth(plan.tail.begin, 1.0, rest[:, 0]), 0.0)
        self._spread *= 1.0 - stiff
        self._folding = np.flatnonzero(part == FIN)
        folding = rows[self._folding]
        first = np.broadcast_to((1.0, 0.0, 0.0), (len(folding), 3))
        self._root = _weights(first, folding[:, 3:6], folding[:, 15], base[self._folding])
        self._stiff = stiff
        share = mesh.vertices[exists, 13]
        self._paddles = [
            _Paddle(
                paddle, sign, number == PECTORAL, mine, base[mine],
                length_cm * rest[mine], share[mine],
            )
            for paddle, number in ((plan.pectoral, PECTORAL), (plan.pelvic, PELVIC))
            for sign in (-1.0, 1.0)
            if paddle and (mine := (part == number) & (side == sign)).any()
        ]  # fmt: skip
        self._jaws = _jaws_of(species, length_cm, rest, part == BODY)
        self.fins = {
            name: np.flatnonzero((part == number) & (side == sign))
            for name, number, sign in FINS
            if ((part == number) & (side == sign)).any()
        }

    def at(self, control: Array, fins: Array | None = None) -> tuple[Array, Array]:
        """Points and normals (T, n, 3) for control points (T, 426, 3).

        `fins` (T, 7) are as in `state.Fishes`; None: at ease, with the mouth shut.
        """
        control = np.asarray(control, np.float64)
        fins = np.tile(AT_EASE, (len(control), 1)) if fins is None else fins
        points = np.empty((len(control), len(self.uv), 3))
        u, v = np.empty_like(points), np.empty_like(points)
        n = self._splines
        for out, weights in ((points, self._place), (u, self._across), (v, self._along)):
            out[:, :n] = _weighted(weights, control)
        points[:, :n, 1] *= 1.0 + fins[:, TAIL, None] * self._spread[:n]
        root, open_ = (
            _weighted(self._root, control),
            fins[:, FOLD] + (1.0 - fins[:, FOLD]) * self._stiff,
        )
        points[:, self._folding] = root + open_[:, None, None] * (points[:, self._folding] - root)
        for one in self._paddles:
            right = int(one.side > 0)
            sweep = fins[:, LEFT_SWEEP + right] if one.moves else np.full(len(fins), SWEEP_RAD)
            lift = fins[:, LEFT_LIFT + right] if one.moves else np.zeros(len(fins))
            back, across = _paddle_axes(one, sweep, lift)
            u[:, one.mine], v[:, one.mine] = back, across
            out = one.outline[:, :1] * back + one.outline[:, 1:] * across
            points[:, one.mine] = control[:, one.base] + out
        normals = np.cross(u, v)
        size = np.linalg.norm(normals, axis=2, keepdims=True)
        # At the snout all control points of a row coincide: the normal points ahead.
        sound = size**2 > 1e-8
        normals = np.where(sound, normals / np.where(sound, size, 1.0), (1.0, 0.0, 0.0))
        normals *= self._outward[:, None]
        if self._jaws:
            _open_mouth(self._jaws, fins[:, MOUTH], points, normals)
        return points, normals


def _weighted(weights: Array, control: Array) -> Array:
    """Sums (T, n, 3) of control points (T, 426, 3), in one product of large matrices."""
    columns = np.swapaxes(control, 0, 1).reshape(control.shape[1], -1)
    return np.swapaxes((weights @ columns).reshape(len(weights), -1, 3), 0, 1)


def _weights(across: Array, along: Array, stride: Array, base: Ints) -> Array:
    """Weights (n, 426) of the control points from those (n, 3) across and along a patch."""
    tap = np.arange(3)
    points = base[:, None, None] + tap[:, None] * stride.astype(int)[:, None, None] + tap
    weight = across[:, :, None].astype(float) * along[:, None, :]
    out = np.zeros((len(base), CONTROL_POINTS))
    # The third row of a linear patch has weight zero and may be beyond the last point.
    row = np.broadcast_to(np.arange(len(base))[:, None, None], points.shape)
    np.add.at(out, (row, np.minimum(points, CONTROL_POINTS - 1)), weight)
    return out


def _paddle_axes(one: _Paddle, sweep: Array, lift: Array) -> tuple[Array, Array]:
    """Directions (T, k, 3) along and across a paired fin with a sweep and a lift (T,), rad."""
    droop, wing = np.radians(one.plan.droop), one.plan.wing
    beat = sweep[:, None, None] * (0.6 + 0.55 * one.along[:, None])
    bend = WING_SPREAD + WING_BEAT * beat if wing else beat
    cos, sin = np.cos(lift)[:, None, None], np.sin(lift)[:, None, None]
    turned = []
    for x, y in (
        (-np.cos(droop), -np.sin(droop)),
        (1.0, 0.0) if wing else (-np.sin(droop), np.cos(droop)),
    ):
        turned.append(cos * np.array([x, y, 0.0]) + sin * np.array([y, -x, 0.0]))
    back, across = turned
    back = back * np.cos(bend) + np.array([0.0, 0.0, one.side]) * np.sin(bend)
    across = across + np.array([0.0, 0.0, 0.0 if wing else LEAN * one.side])
    across /= np.linalg.norm(across, axis=2, keepdims=True)
    return back, np.broadcast_to(across, back.shape)


def _jaws_of(species: Species, length_cm: float, rest: Array, body: Bools) -> _Jaws | None:
    """The vertices that move with the mouth; `rest` (n, 2) are places on the skin."""
    opening_rad, soft = jaws(species)
    (tip, high), (corner, low) = species.skin.mouth
    reach = corner - tip
    behind = (rest[:, 0] - tip) / reach
    mine = np.flatnonzero(body & (behind < BEHIND))
    if not opening_rad or not len(mine):
        return None
    rest, behind = rest[mine], behind[mine]
    above = (rest[:, 1] - high - behind * (low - high)) / soft - LIFT
    lower = 1.0 - _smooth(-1.0, 1.0, above)
    jaw, snout = 1.0 - _smooth(0.8, BEHIND, behind), 1.0 - _smooth(0.0, BEHIND, behind)
    between = 4.0 * lower * (1.0 - lower) * (1.0 - _smooth(0.0, 1.0, behind))
    return _Jaws(
        mine=mine,
        opening_rad=opening_rad,
        share=(1.0 - lower) * 0.3 * snout - lower * jaw,
        arm=length_cm * np.stack([corner + JOINT * reach - rest[:, 0], rest[:, 1] - low], axis=1),
        pull=length_cm * reach * between,
    )


def _open_mouth(one: _Jaws, mouth: Array, points: Array, normals: Array) -> None:
    """Turn the jaws of points and normals (T, n, 3) for mouths (T,) from 0, shut, to 1."""
    gape = (mouth**2 * one.opening_rad)[:, None]
    cos, sin = np.cos(gape * one.share), np.sin(gape * one.share)
    x, y = one.arm.T
    place, normal = points[:, one.mine], normals[:, one.mine]
    place[..., 0] += cos * x - sin * y - x
    place[..., 1] += sin * x + cos * y - y
    place -= normal * (gape * one.pull)[..., None]
    nx, ny = normal[..., 0].copy(), normal[..., 1].copy()
    normal[..., 0], normal[..., 1] = cos * nx - sin * ny, sin * nx + cos * ny
    points[:, one.mine], normals[:, one.mine] = place, normal


def _smooth(start: float, end: float, x: Array) -> Array:
    """From 0 at `start` to 1 at `end`, as GLSL's smoothstep."""
    t = np.clip((x - start) / (end - start), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


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
