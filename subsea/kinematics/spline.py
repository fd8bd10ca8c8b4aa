"""Pre-evaluated tables of clamped B-spline bases (SMC §7.2).

Bodies are quadratic in u and v: "order 3" of SMC in the usual count, degree plus one. A quadratic
is C1, so normals are continuous; it stays nearer to the control mesh than a cubic, so the change
to the mesh of the next level shows less; and a vertex needs 9 control points instead of 16. Fins
are linear across and quadratic along.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]

DEGREE = 2
TAPS = DEGREE + 1


class Table(NamedTuple):
    """A basis at parameters t: point(t_k) = Σ_j weight[k, j] · control[first[k] + j]."""

    first: Ints  # (k,) the first control point that has a part
    weight: Array  # (k, 3)
    slope: Array  # (k, 3) derivatives of the weights by t


def basis_table(controls: int, samples: int, degree: int = DEGREE) -> Table:
    """The clamped uniform basis of `controls` points at `samples` even parameters in [0, 1].

    Degree 2, or 1 for two taps and a third that is zero. Evaluated by the Cox-de Boor recursion.
    A coarser level takes every second sample: `decimated`.
    """
    if degree not in (1, 2) or controls < degree + 1:
        raise ValueError(f"no basis of degree {degree} on {controls} points")
    t = np.linspace(0.0, 1.0, samples)
    spans = controls - degree
    inner = np.arange(spans + 1) / spans
    knots = np.concatenate([np.zeros(degree), inner, np.ones(degree)])
    cell = np.minimum((t * spans).astype(np.int64), spans - 1)
    basis = [_order_zero(knots, cell)]
    for d in range(1, degree + 1):
        basis.append(_raise_degree(knots, basis[-1], t, d))
    lower = basis[-2]
    left = _ratio(np.ones_like(t)[:, None], knots[degree : degree + controls] - knots[:controls])
    right = _ratio(
        np.ones_like(t)[:, None],
        knots[degree + 1 : degree + 1 + controls] - knots[1 : controls + 1],
    )
    slope = degree * (left * lower[:, :controls] - right * lower[:, 1 : controls + 1])
    first = np.minimum(cell, controls - TAPS) if controls >= TAPS else np.zeros_like(cell)
    taps = first[:, None] + np.arange(TAPS)
    return Table(first, _gather(basis[-1], taps), _gather(slope, taps))


def decimated(table: Table, step: int) -> Table:
    """Every `step`-th sample: the coarser levels are subsets of the finest."""
    return Table(*(values[::step] for values in table))


def _order_zero(knots: Array, cell: Ints) -> Array:
    """Degree 0: one in the cell that holds t; the last cell is closed."""
    out = np.zeros((len(cell), len(knots) - 1))
    padding = int(np.flatnonzero(np.diff(knots) > 0)[0])
    out[np.arange(len(cell)), cell + padding] = 1.0
    return out


def _raise_degree(knots: Array, lower: Array, t: Array, degree: int) -> Array:
    count = lower.shape[1] - 1
    k = knots
    rise = _ratio(t[:, None] - k[:count], k[degree : degree + count] - k[:count])
    fall = _ratio(
        k[degree + 1 : degree + 1 + count] - t[:, None],
        k[degree + 1 : degree + 1 + count] - k[1 : count + 1],
    )
    return np.asarray(rise * lower[:, :count] + fall * lower[:, 1 : count + 1])


def _ratio(numerator: Array, denominator: Array) -> Array:
    """The recursion's 0/0 is 0."""
    safe = np.where(denominator == 0.0, 1.0, denominator)
    return np.where(denominator == 0.0, 0.0, numerator / safe)


def _gather(values: Array, taps: Ints) -> Array:
    """Columns `taps` of each row; those beyond the last control point are zero."""
    padded = np.pad(values, ((0, 0), (0, TAPS)))
    return np.asarray(np.take_along_axis(padded, taps, axis=1))
