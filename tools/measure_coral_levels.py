"""Measure how the levels of corals differ: `python tools/measure_coral_levels.py [KIND…]`.

Each level is drawn at the widths in pixels at which it is used, in plain grey. Its error is the sum
of the differences over the light of the finest level, a mean over two variants from two sides.
"""

import argparse

import numpy as np

from subsea.base.arrays import Array
from subsea.rendering.reef.coral_kinds import LEVELS, LUMPS, SHAPES, shape
from subsea.rendering.reef.coral_mesh import CoralMesh

SIDES = ((0.5, 0.35), (2.2, 0.6))  # yaw and pitch of the eye, rad
SIZES = {3: 57, 4: 32, 5: 16}  # pixels across at which a level is judged
SAMPLES = 4  # along each side of a pixel
WIDE, HIGH, BELOW = 2.2, 2.86, 0.4  # of the frame, and its part below the foot, over the radius
SUN = np.array([0.3, -0.5, 0.8])


def picture(mesh: CoralMesh, pixels: int, yaw: float, pitch: float) -> Array:
    """Draw a mesh in grey, `pixels` wide, without perspective."""
    fine = pixels * SAMPLES
    sharp = np.zeros((int(fine * HIGH / WIDE), fine))
    nearest = np.full(sharp.shape, np.inf)
    turn = np.array(
        [[np.cos(yaw), np.sin(yaw), 0.0], [-np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]]
    )
    place, normal = mesh.place @ turn.T, mesh.normal @ turn.T
    lit = 0.3 + 0.7 * np.clip((normal @ SUN + 0.3) / 1.3, 0.0, 1.0)
    grey = lit * mesh.light * (0.4 + 0.6 * mesh.tip)
    x = (place[:, 0] / WIDE + 0.5) * fine
    up = place[:, 2] * np.cos(pitch) + place[:, 1] * np.sin(pitch)
    y = len(sharp) - (up + BELOW) / WIDE * fine
    away = place[:, 1] * np.cos(pitch) - place[:, 2] * np.sin(pitch)
    for corners in mesh.triangles:
        (ax, bx, cx), (ay, by, cy) = x[corners], y[corners]
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if area >= 0.0:  # its back
            continue
        left, right = max(int(min(ax, bx, cx)), 0), int(max(ax, bx, cx)) + 1
        top, low = max(int(min(ay, by, cy)), 0), int(max(ay, by, cy)) + 1
        part = sharp[top:low, left:right]
        rows, columns = np.mgrid[: part.shape[0], : part.shape[1]]
        px, py = columns + left + 0.5, rows + top + 0.5
        a = ((bx - px) * (cy - py) - (cx - px) * (by - py)) / area
        b = ((cx - px) * (ay - py) - (ax - px) * (cy - py)) / area
        shares = np.stack([a, b, 1.0 - a - b], axis=-1)
        far, front = shares @ away[corners], nearest[top:low, left:right]
        seen = (shares >= 0.0).all(axis=-1) & (far < front)
        front[seen], part[seen] = far[seen], (shares @ grey[corners])[seen]
    rows = len(sharp) // SAMPLES
    whole = sharp[: rows * SAMPLES].reshape(rows, SAMPLES, pixels, SAMPLES)
    return np.asarray(whole.mean(axis=(1, 3)))


def error(kind: str, level: int) -> tuple[float, float]:
    """Measure the error of a level, and its light over that of the finest level."""
    errors, lights = [], []
    for variant in (0, 1):
        for side in SIDES:
            finest, drawn = (
                picture(shape(kind, variant, k), SIZES[level], *side) for k in (0, level)
            )
            errors.append(np.abs(drawn - finest).sum() / finest.sum())
            lights.append(drawn.sum() / finest.sum())
    return float(np.mean(errors)), float(np.mean(lights))


def main() -> None:
    """Print a line for each kind."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="*", metavar="KIND", default=list(SHAPES))
    for kind in parser.parse_args().kinds:
        parts = [f"{kind:9}"]
        for level in range(min(SIZES), LEVELS if kind in LUMPS else LEVELS - 1):
            wrong, light = error(kind, level)
            triangles = len(shape(kind, 1, level).triangles)
            parts.append(
                f"level {level} at {SIZES[level]} px: error {wrong:.2f}, light {light:.2f}, "
                f"{triangles} triangles"
            )
        print(" | ".join(parts))


if __name__ == "__main__":
    main()
