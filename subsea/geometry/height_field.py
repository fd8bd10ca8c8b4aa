"""A height field over a square: bilinear lookup for compiled kernels."""

from subsea.base.arrays import Array
from subsea.kernels import kernel


@kernel
def height_at(heights: Array, half_width: float, x: float, y: float) -> float:
    """Height in cm at (x, y); outside the square [-w, w]² that of its edge.

    `heights` is (n, n), row i along y and column j along x, samples from -w to w inclusive.
    """
    n = heights.shape[0]
    step = 2.0 * half_width / (n - 1)
    u = min(max((x + half_width) / step, 0.0), n - 1.0)
    v = min(max((y + half_width) / step, 0.0), n - 1.0)
    j = min(int(u), n - 2)
    i = min(int(v), n - 2)
    a, b = u - j, v - i
    return (
        (1.0 - b) * ((1.0 - a) * heights[i, j] + a * heights[i, j + 1])
        + b * ((1.0 - a) * heights[i + 1, j] + a * heights[i + 1, j + 1])
    )  # fmt: skip
