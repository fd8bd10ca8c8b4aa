"""A segment from above: along and across its path.

Points are complex numbers: the real part is ahead and the imaginary part to the left, in cm. A
rotation is a product.
"""

from cmath import phase
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from capture.inspection.simulated import replay
from subsea.base.arrays import Array
from subsea.biomechanics.body import LOWER_TAIL, RINGS, UPPER_TAIL, Floats, body_frame
from subsea.repertoire import Segment

Complex = NDArray[np.complex128]

STRAIGHT = 1e-3  # change of heading in a cycle, rad, below which its path counts as straight


class TopView(NamedTuple):
    """A replayed segment from above, that begins along its path."""

    nodes: Complex  # (t, 23)
    midline: Complex  # (t, 7) nose, five ring centres, tail
    origin: Complex  # (t,) of the body frame
    forward: Complex  # (t,) its x axis, of length 1 when level
    right: Complex  # (t,) its z axis


def top_view(segment: Segment, cycles: int) -> TopView:
    """Replay ``cycles`` cycles of a segment (1 if it is not cyclic)."""
    frames = replay(segment, np.zeros(3), np.eye(3), cycles if segment.cyclic else 1)
    origin, rotation = body_frame(frames)
    start = np.conj(path_direction(segment))
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
    """Offset (t, 7) of the midline to the right of the path, cm.

    The path of a cycle is its mean line or circle, that of other segments the body axis.
    """
    if not segment.cyclic:
        return np.asarray(midline(segment.nodes)[..., 2])
    turn, shift = _cycle(segment)
    played = top_view(segment, cycles)
    if abs(turn) < STRAIGHT:
        aside = -np.imag(played.midline)
    else:
        centre = shift / (1 - np.exp(1j * turn)) * np.conj(path_direction(segment))
        aside = np.sign(turn) * np.abs(played.midline - centre)
    return np.asarray(aside - aside[:, :1].mean())  # the nose sways about the path


def speeds(segment: Segment, tick_s: float, cycles: int) -> Floats:
    """Horizontal speed (t - 1,) of the mean of all nodes over each tick, cm/s."""
    middle = top_view(segment, cycles).nodes.mean(axis=1)
    return np.asarray(np.abs(np.diff(middle)) / tick_s)


def spectrum(values: Floats, tick_s: float, cyclic: bool) -> tuple[Floats, Floats]:
    """Frequencies, Hz, and amplitudes of the Fourier series of ``values`` (t,).

    A cycle is a whole period and needs no window; other values get a Hann window.
    """
    window = np.ones(len(values)) if cyclic else np.hanning(len(values) + 1)[:-1]
    amplitude = 2 * np.abs(np.fft.rfft((values - values.mean()) * window)) / window.sum()
    return np.asarray(np.fft.rfftfreq(len(values), tick_s)), np.asarray(amplitude)


def _cycle(segment: Segment) -> tuple[float, complex]:
    """Rotation of the body frame over the segment, rad to the left, and its displacement."""
    last = replay(segment, np.zeros(3), np.eye(3), 1)[-1]
    origin, rotation = body_frame(last)
    heading, shift = complex(above(rotation[:, 0])), complex(above(origin))
    return phase(heading), shift


def path_direction(segment: Segment) -> complex:
    """Initial direction of the path of a cycle in the body frame, of length 1."""
    if not segment.cyclic:
        return 1 + 0j
    turn, shift = _cycle(segment)
    chord = shift * np.exp(-0.5j * turn)  # the chord of an arc is rotated by half its angle
    return complex(chord / abs(chord))
