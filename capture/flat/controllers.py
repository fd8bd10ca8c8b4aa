"""Control the muscles of a flat fish by sinusoids, and pass from one to the next (KS I.D)."""

from typing import NamedTuple

import numpy as np

from capture.flat.physics import heading, is_sound, middle, swim
from capture.flat.scaffold import FlatBody
from subsea.biomechanics.body import Floats
from subsea.biomechanics.controllers import ease

STEP_TU = 0.055  # the step of the three-dimensional fish
FRAME = 6  # steps between two stored states
FRAME_TU = FRAME * STEP_TU
LARGEST = 0.15  # bound of the amplitudes, relative to a muscle's length
FREQUENCIES = (0.05, 0.4)  # bounds of the frequencies, beats a tu
TRY_TU = 60.0  # duration of a try
MEAN = 30  # frames, about 10 tu, over which headings are averaged: the yaw of a beat cancels
RISE_TU = 4.0  # duration of a fade-in, and of a transition between controllers
WAYS = ("parameters", "phases", "lengths")  # to pass from one controller to the next


class Sinusoids(NamedTuple):
    """A controller: a muscle's length at rest is l (1 + amplitude sin(2π frequency t + phase))."""

    amplitude: Floats  # (m,)
    frequency: Floats  # (m,) beats a tu
    phase: Floats  # (m,) rad

    def angles(self, time: Floats) -> Floats:
        """Compute the angles (t, m), rad, at these times, tu."""
        return np.asarray(2.0 * np.pi * self.frequency * time[:, None] + self.phase)

    def mirrored(self, body: FlatBody) -> "Sinusoids":
        """Swap left and right."""
        return Sinusoids(*(part[body.mirror] for part in self))


def controller_at(body: FlatBody, point: Floats, largest: float = LARGEST) -> Sinusoids:
    """Map a point of the unit box: amplitudes, phases, then a frequency for all or for each."""
    low, high = FREQUENCIES
    many = len(body.mirror)
    frequency = low + point[2 * many :] * (high - low)
    return Sinusoids(
        largest * point[:many],
        np.broadcast_to(frequency, many).copy(),
        2.0 * np.pi * point[many : 2 * many],
    )


def steps_of(tu: float) -> int:
    """Count the steps of whole frames in a time."""
    return round(tu / STEP_TU / FRAME) * FRAME


def lengths(
    body: FlatBody, controller: Sinusoids, steps: int, begin: float = 0.0, step: float = STEP_TU
) -> Floats:
    """Compute the lengths (steps, m) of muscles at rest, cm, from `begin` on, tu; faded in at 0."""
    time = begin + step * np.arange(steps, dtype=np.float64)
    wave = controller.amplitude * np.sin(controller.angles(time))
    natural = body.length[: len(body.mirror)]
    return np.asarray(natural * (1.0 + ease(time / RISE_TU)[:, None] * wave))


def passage(
    body: FlatBody, old: Sinusoids, new: Sinusoids, begin: float, way: str = "lengths"
) -> Floats:
    """Compute lengths (steps, m) of a transition from ``old`` to ``new`` that starts at ``begin``.

    Linear in the ``parameters`` (amplitudes, frequencies, phases, as in KS); in ``phases``: the
    same with a continuous phase; or in ``lengths``: a blend of both outputs.
    """
    time = begin + STEP_TU * np.arange(steps_of(RISE_TU), dtype=np.float64)
    share = np.linspace(0.0, 1.0, len(time))[:, None]
    first, last = old.angles(time), new.angles(time)
    if way == "lengths":
        wave = (1 - share) * old.amplitude * np.sin(first) + share * new.amplitude * np.sin(last)
    elif way == "parameters":
        amplitude, frequency, phase = (
            (1 - share) * a + share * b for a, b in zip(old, new, strict=True)
        )
        wave = amplitude * np.sin(2.0 * np.pi * frequency * time[:, None] + phase)
    else:
        frequency = (1 - share) * old.frequency + share * new.frequency
        angle = first[0] + 2.0 * np.pi * STEP_TU * np.cumsum(frequency, axis=0)
        late = (last[-1] - angle[-1] + np.pi) % (2.0 * np.pi) - np.pi
        wave = ((1 - share) * old.amplitude + share * new.amplitude) * np.sin(angle + share * late)
    return np.asarray(body.length[: len(body.mirror)] * (1.0 + wave))


def run(body: FlatBody, muscles: Floats, start: Floats | None = None) -> Floats:
    """Swim, implicitly, from a state (2, n, 2) or from rest: states (frames, 2, n, 2)."""
    start = body.at_rest() if start is None else start
    return np.asarray(swim(body, start, muscles, STEP_TU, True, FRAME))


def swim_by(body: FlatBody, controller: Sinusoids, start: Floats | None = None) -> Floats:
    """Swim for the time of a try: states (frames, 2, n, 2)."""
    return run(body, lengths(body, controller, steps_of(TRY_TU)), start)


def distance(body: FlatBody, controller: Sinusoids) -> float:
    """Score as KS: body lengths of the centre of mass ahead; -1 for a folded fish."""
    frames = swim_by(body, controller)
    if not is_sound(body, frames):
        return -1.0
    return float((middle(body, frames[-1, 0]) - middle(body, body.rest))[0] / body.long)


def turned(body: FlatBody, start: Floats, controller: Sinusoids) -> float:
    """Score a turn from a state: the angle to the left in a try, degrees; -180 if folded."""
    frames = swim_by(body, controller, start)
    if not is_sound(body, frames):
        return -180.0
    return gained(np.degrees(heading(body, frames[:, 0])))


def gained(angle: Floats) -> float:
    """Subtract the means of a heading (T,) over its first and last beat."""
    return float(angle[-MEAN:].mean() - angle[:MEAN].mean())
