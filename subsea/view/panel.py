"""The panel with text before an observer in a headset."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array


class Panel(NamedTuple):
    """A flat rectangle on the observer, with the axes right, up, ahead, in cm."""

    middle: Array  # (3,)
    right: Array  # (3,) from its middle to its right edge
    up: Array  # (3,) from its middle to its upper edge

    def places(self, x: Array, y: Array) -> Array:
        """Places (n, 3) of points in shares (n,) of the panel from its upper left corner."""
        across, high = 2.0 * np.asarray(x) - 1.0, 1.0 - 2.0 * np.asarray(y)
        return self.middle + across[:, None] * self.right + high[:, None] * self.up

    def hit(self, start: Array, way: Array) -> tuple[float, float] | None:
        """Shares of the panel from its upper left corner where a ray meets it; None beside it."""
        normal = np.cross(self.right, self.up)
        toward = float(way @ normal)
        if abs(toward) < 1e-9 * np.linalg.norm(normal):
            return None
        distance = float((self.middle - start) @ normal) / toward
        if distance <= 0.0:
            return None
        at = start + distance * way - self.middle
        across, high = float(at @ self.right), float(at @ self.up)
        x = 0.5 + 0.5 * across / float(self.right @ self.right)
        y = 0.5 - 0.5 * high / float(self.up @ self.up)
        return (x, y) if 0.0 <= x <= 1.0 and 0.0 <= y <= 1.0 else None


# As large as a screen of 70 inches, a little below the eyes, tilted to face them.
PANEL = Panel(np.array([0.0, -14.0, 150.0]), np.array([78.0, 0.0, 0.0]), np.array([0.0, 43.7, 4.2]))
