"""The outline of a ray's disc for its simulation, and the surface that follows its motion."""

import numpy as np

from capture.recording.spine_manoeuvre import ease
from capture.recording.spine_motion import rest_nodes
from capture.recording.spine_water import fin_height
from subsea.base.arrays import Array
from subsea.biomechanics.disc import LAYERS, Disc, DiscOutline
from subsea.fish.skinning import hermite
from subsea.fish.spine import SpinePlan
from subsea.fish.surface import SurfacePlan, along, rest_surface

COLUMNS = np.array([0.0, 0.27, 0.5, 0.7, 0.87])  # places of the nodes, half spans from the spine
ROWS = 5
INSIDE = 0.08  # share of the chord at the edges that is left out, where the disc has no thickness
SAMPLES = 200  # of the span of a column
LEAST_CHORD = 0.03  # body lengths: at the tip shares of the chord mean nothing
DIFFERENCE = 1e-3  # body lengths
JOINTS = 32  # of the tail
STRAIGHTENED = 0.6  # share of the angle to the trunk, in a tick
SMOOTHED = 3  # times, where the tail leaves the disc
JOINED = 0.03  # body lengths over which the disc passes into the tail


def disc_outline(surface: SurfacePlan, length: float) -> DiscOutline:
    """The shape of a ray's disc, cm; ``length`` is that of the fish."""
    wing = surface.wing
    assert wing
    share = np.concatenate([-COLUMNS[:0:-1], COLUMNS])
    right = share * wing.span
    between = 0.5 * (right[1:] + right[:-1])
    edges = np.concatenate([[-wing.span], between, [wing.span]])
    at = edges[:-1, None] + np.diff(edges)[:, None] * (np.arange(SAMPLES) + 0.5) / SAMPLES
    chords = chord_at(surface, at)[1]
    front, chord = chord_at(surface, right)
    rows = np.linspace(0.0, 1.0, ROWS)
    x = front[:, None] + chord[:, None] * np.clip(rows, INSIDE, 1.0 - INSIDE)
    thick = along(surface.back, x) - along(surface.belly, x)
    thick = thick * along(np.asarray(wing.thickness), np.abs(share))[:, None]
    middle = len(right) // 2
    trunk = front[middle] + chord[middle] * rows
    tail = np.linspace(trunk[-1], 1.0, SAMPLES)
    girth = np.pi * (
        along(surface.width, tail) + 0.5 * (along(surface.back, tail) - along(surface.belly, tail))
    )
    return DiscOutline(
        right=right * length,
        front=front * length,
        chord=chord * length,
        chords=chords.mean(axis=1) * np.diff(edges) * length**2,
        squares=(chords**2).mean(axis=1) * np.diff(edges) * length**3,
        thick=np.asarray(thick) * length,
        side=fin_height(surface, trunk) * length,
        fin=float(fin_height(surface, trunk[-1:])[0]) * length,
        tail=float(girth.mean() * (1.0 - trunk[-1])) * length**2,
    )


def chord_at(surface: SurfacePlan, right: Array) -> tuple[Array, Array]:
    """Front edge and chord of the disc at distances ``right`` of the spine, body lengths."""
    wing = surface.wing
    assert wing
    outline = np.array(wing.outline)
    ahead, rear = outline[: wing.tip + 1], outline[wing.tip :][::-1]
    reach = np.abs(right)
    front = np.interp(reach, ahead[:, 1], ahead[:, 0])
    return front, np.interp(reach, rear[:, 1], rear[:, 0]) - front


class DiscSurface:
    """Nodes and control points of a ray that follow its disc and its tail.

    Places of the disc are (T, J, I, 3) in body lengths: ahead, up, right.
    """

    def __init__(self, plan: SpinePlan, surface: SurfacePlan, disc: Disc) -> None:
        """Couple the surface at rest to the disc at rest."""
        rest = np.concatenate([rest_nodes(plan, surface), rest_surface(surface)])
        self._up = rest[:, 1]
        self._surface = surface
        self._flat = rest * (1.0, 0.0, 1.0)
        self._still = middles(disc, disc.rest) / plan.length
        self._rear = float(-self._still[len(self._still) // 2, -1, 0])
        self._weights = self._couple(self._flat)
        self._near = []
        for axis in (0, 2):
            points = [self._flat + side * DIFFERENCE * np.eye(3)[axis] for side in (1.0, -1.0)]
            self._near.append([(one, self._couple(one)) for one in points])
        self._tail = ease((rest[:, 0] - self._rear) / JOINED + 0.5)
        self.joint = (1.0 - self._rear) / JOINTS

    def _couple(self, points: Array) -> Array:
        """Weights (p, J, I) of the nodes of the disc at points (p, 3) in its plane."""
        x, right = points[:, 0], points[:, 2]
        front, chord = chord_at(self._surface, right)
        share = (x - front) / np.maximum(chord, LEAST_CHORD)
        share = np.clip(share, -0.5, 1.5)
        columns, rows = self._still[:, 0, 2], np.linspace(0.0, 1.0, self._still.shape[1])
        return np.einsum("pj,pi->pji", hermite(-columns, -right), hermite(-rows, -share))

    def pose(self, disc: Array, tail: Array) -> Array:
        """Nodes and points (T, p, 3) on a disc (T, J, I, 3) with the joints (T, n, 3) of a tail."""
        moved = disc - self._still

        def place(points: Array, weights: Array) -> Array:
            return np.asarray(
                points * (-1.0, 1.0, 1.0) + np.einsum("pji,tjic->tpc", weights, moved)
            )

        here = place(self._flat, self._weights)
        back, aside = (place(*after) - place(*before) for after, before in self._near)
        normal = np.cross(back, aside)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        on_disc = here + self._up[:, None] * normal
        share = self._tail[:, None]
        return np.asarray((1.0 - share) * on_disc + share * self._behind(tail, disc))

    def _behind(self, tail: Array, disc: Array) -> Array:
        """Points (T, p, 3) as far along the tail as at rest."""
        middle = disc.shape[1] // 2
        aside = disc[:, middle + 1].mean(axis=1) - disc[:, middle - 1].mean(axis=1)
        at = (self._flat[:, 0] - self._rear) / self.joint
        cell = np.clip(at.astype(int), 0, tail.shape[1] - 2)
        within = (at - cell)[:, None]
        here = (1.0 - within) * tail[:, cell] + within * tail[:, cell + 1]
        slope = np.gradient(tail, axis=1)
        inner = np.clip(within, 0.0, 1.0)
        back = (1.0 - inner) * slope[:, cell] + inner * slope[:, cell + 1]
        back /= np.linalg.norm(back, axis=-1, keepdims=True)
        up = np.cross(back, aside[:, None])
        up /= np.linalg.norm(up, axis=-1, keepdims=True)
        right = np.cross(up, back)
        return np.asarray(here + self._up[:, None] * up + self._flat[:, 2:] * right)


def middles(disc: Disc, frames: Array) -> Array:
    """Middles (…, J, I, 3) of back and belly of nodes (…, n, 3)."""
    shape = (*frames.shape[:-2], disc.columns, disc.rows, LAYERS, 3)
    return np.asarray(frames.reshape(shape).mean(axis=-2))


def draw_tail(trunk: Array, joint: float) -> Array:
    """Joints (T, n + 1, 3) of a tail that is drawn along by the trunk.

    ``trunk`` (T, 2, 3) are the middles of its rear and its front edge. Each joint follows the one
    before it, ``joint`` behind: water lets a whip slip along itself but not aside. The whip is
    stiff, so it slowly turns to the axis of the trunk. At first it has that direction.
    """
    axes = trunk[:, 0] - trunk[:, 1]
    axes *= joint / np.linalg.norm(axes, axis=-1, keepdims=True)
    joints = np.empty((len(trunk), JOINTS + 1, 3))
    now = trunk[0, 0] + np.arange(JOINTS + 1)[:, None] * axes[0]
    for t, axis in enumerate(axes):
        now[0] = trunk[t, 0]
        for k in range(1, JOINTS + 1):
            apart = now[k] - now[k - 1]
            apart += STRAIGHTENED * (axis - apart)
            now[k] = now[k - 1] + joint / np.linalg.norm(apart) * apart
        joints[t] = now
    for _ in range(SMOOTHED):
        joints[:, 1:-1] = 0.25 * (joints[:, :-2] + 2.0 * joints[:, 1:-1] + joints[:, 2:])
    return joints
