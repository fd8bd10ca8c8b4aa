"""Draw a flat fish with matplotlib: its body within its scaffold, as in KS III.A."""

from typing import Any

import numpy as np

from capture.flat.scaffold import FlatBody, Ints
from subsea.biomechanics.body import Floats

# The palette of Okabe and Ito, safe for colour-blind readers.
BLUE, ORANGE, GREEN, PINK, YELLOW, BLACK, GREY = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#222222", "#999999",
)  # fmt: skip
SLIM = 0.8  # width of the body over that of its scaffold
STATIONS = 60  # along each side of the body's outline


class Skin:
    """The outline of a body, each of its points bound to the triangle that contains it (KS III.A).

    `triangle` (p,), and barycentric coordinates `shares` (p, 3).
    """

    def __init__(self, body: FlatBody) -> None:
        self.body = body
        loop = body.rest[body.hull[:, 0]]
        loop = np.roll(loop, -int(loop[:, 0].argmax()), axis=0)  # from the nose, left side first
        tail = int(loop[:, 0].argmin())
        at = np.linspace(loop[0, 0], loop[tail, 0], STATIONS)
        left, right = loop[: tail + 1], np.concatenate([loop[tail:], loop[:1]])[::-1]
        sides = [
            np.stack([at, SLIM * np.interp(-at, -side[:, 0], side[:, 1])], 1)
            for side in (left, right)
        ]
        outline = np.concatenate([sides[0], sides[1][::-1]])
        corners = body.rest[body.triangles]  # (t, 3, 2)
        basis = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=-1)
        shares = np.linalg.solve(basis, (outline[:, None] - corners[:, 0])[..., None])[..., 0]
        shares = np.concatenate([1.0 - shares.sum(axis=2, keepdims=True), shares], axis=2)
        self.triangle: Ints = shares.min(axis=2).argmax(axis=1)
        self.shares: Floats = shares[np.arange(len(outline)), self.triangle]

    def outline(self, x: Floats) -> Floats:
        """Place the outline (..., p, 2) on a scaffold (..., n, 2): left side, right side back."""
        corners = x[..., self.body.triangles[self.triangle], :]
        return np.asarray(np.einsum("pk,...pkc->...pc", self.shares, corners))

    def midline(self, x: Floats) -> Floats:
        """Place the middles (..., p/2, 2) of both sides on a scaffold, nose first."""
        outline = self.outline(x)
        both = outline[..., :STATIONS, :] + outline[..., STATIONS:, :][..., ::-1, :]
        return np.asarray(0.5 * both)


def draw_fish(axis: Any, skin: Skin, x: Floats, colour: str = BLUE, alpha: float = 1.0) -> None:
    """Draw the body on a scaffold (n, 2), in body lengths."""
    shape = skin.outline(x) / skin.body.long
    axis.fill(*shape.T, facecolor=colour, edgecolor="none", alpha=0.25 * alpha)
    axis.plot(*np.concatenate([shape, shape[:1]]).T, color=colour, linewidth=0.9, alpha=alpha)


def draw_scaffold(axis: Any, body: FlatBody, x: Floats, scale: float = 1.0) -> tuple[Any, Any]:
    """Draw the units in body lengths, muscles in colour; return both collections of lines."""
    from matplotlib.collections import LineCollection

    lines, muscles = list(x[body.units] / body.long), len(body.mirror)
    thin = LineCollection(lines[muscles:], colors=BLACK, linewidths=0.8 * scale)
    thick = LineCollection(lines[:muscles], colors=ORANGE, linewidths=2.6 * scale)
    return axis.add_collection(thin), axis.add_collection(thick)


def bare(axis: Any, width: tuple[float, float], height: tuple[float, float]) -> None:
    """Leave an axis without frame and ticks, for a small fish."""
    axis.set(aspect="equal", xlim=width, ylim=height, xticks=[], yticks=[])
    axis.spines[:].set_visible(False)
