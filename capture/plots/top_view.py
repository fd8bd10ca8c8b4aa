"""A segment as it is looked at: from above, along and across its way, beat by beat.

Points seen from above are complex numbers: the real part is ahead and the imaginary part to the
left, in cm. A turn is then a product.
"""

from cmath import phase
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from capture.inspection.simulated import replay
from subsea.biomechanics.body import LOWER_TAIL, RINGS, UPPER_TAIL, Floats
from subsea.biomechanics.body_frame import body_frame
from subsea.core.arrays import Array
from subsea.repertoire import Segment

Complex = NDArray[np.complex128]

STRAIGHT = 1e-3
"""Radians of heading a cycle below which its way counts as straight."""


class TopView(NamedTuple):
    """A segment played back so that it begins along its way, from above."""

    nodes: Complex  # (t, 23)
    midline: Complex  # (t, 7) nose, five ring centres, tail
    origin: Complex  # (t,) of the body frame
    forward: Complex  # (t,) its x axis, of length 1 when level
    right: Complex  # (t,) its z axis


def top_view(segment: Segment, cycles: int) -> TopView:
    """The states of ``cycles`` cycles (1 if it isn't cyclic), each after its increment."""
    frames = replay(segment, np.zeros(3), np.eye(3), cycles if segment.cyclic else 1)
    origin, rotation = body_frame(frames)
    start = np.conj(_direction(segment))
    return TopView(
        *(
            start * above(points)
            for points in (frames, midline(frames), origin, rotation[..., 0], rotation[..., 2])
        )
    )


def above(points: Array) -> Complex:
    """Points (…, 3) in axes x ahead, y up, z right as complex numbers (…)."""
    return np.asarray(points[..., 0] - 1j * points[..., 2])


def midline(nodes: Array) -> Floats:
    """Nose, centres of the five rings and middle of the tail (…, 7, 3) of nodes (…, 23, 3)."""
    rings = nodes[..., 1:21, :].reshape(*nodes.shape[:-2], RINGS, 4, 3).mean(axis=-2)
    tail = nodes[..., [UPPER_TAIL, LOWER_TAIL], :].mean(axis=-2, keepdims=True)
    return np.asarray(np.concatenate([nodes[..., :1, :], rings, tail], axis=-2), np.float64)


def lateral_offset(segment: Segment, cycles: int = 1) -> Floats:
    """How far the midline stands to the right (t, 7), cm: of the way, or of the body axis.

    The way of a cycle is the straight line or the circle that it follows in the mean. A segment
    that isn't cyclic has no such way, so the axis of the body frame stands for it.
    """
    if not segment.cyclic:
        return np.asarray(midline(segment.nodes)[..., 2])
    turn, shift = _cycle(segment)
    played = top_view(segment, cycles)
    if abs(turn) < STRAIGHT:
        aside = -np.imag(played.midline)
    else:
        centre = shift / (1 - np.exp(1j * turn)) * np.conj(_direction(segment))
        aside = np.sign(turn) * np.abs(played.midline - centre)
    return np.asarray(aside - aside[:, :1].mean())  # the nose sways about the way


def speeds(segment: Segment, tick_s: float, cycles: int) -> Floats:
    """Speed of the middle of all nodes over each tick (t - 1,), cm/s, from above."""
    middle = top_view(segment, cycles).nodes.mean(axis=1)
    return np.asarray(np.abs(np.diff(middle)) / tick_s)


def spectrum(values: Floats, tick_s: float, cyclic: bool) -> tuple[Floats, Floats]:
    """Frequencies, Hz, and the amplitudes of the sines that ``values`` (t,) are made of.

    One cycle is a whole period and needs no window; anything else is tapered (Hann).
    """
    window = np.ones(len(values)) if cyclic else np.hanning(len(values) + 1)[:-1]
    amplitude = 2 * np.abs(np.fft.rfft((values - values.mean()) * window)) / window.sum()
    return np.asarray(np.fft.rfftfreq(len(values), tick_s)), np.asarray(amplitude)


def _cycle(segment: Segment) -> tuple[float, complex]:
    """The turn of the body frame over the segment, radians to the left, and its shift."""
    last = replay(segment, np.zeros(3), np.eye(3), 1)[-1]
    origin, rotation = body_frame(last)
    heading, shift = complex(above(rotation[:, 0])), complex(above(origin))
    return phase(heading), shift


def _direction(segment: Segment) -> complex:
    """Where the way of a cycle leads at its beginning, in the body frame; of length 1."""
    if not segment.cyclic:
        return 1 + 0j
    turn, shift = _cycle(segment)
    chord = shift * np.exp(-0.5j * turn)  # a chord of a circle stands half the turn aside
    return complex(chord / abs(chord))
