"""The echo of a place with stone around: a network of delay lines that feed each other."""

import math

import numpy as np

from subsea.base.arrays import Array
from subsea.kernels import kernel
from subsea.sound.space import RATE

LINES = np.array([613, 887, 1181, 1489])  # samples: 19 to 46 m of way in water
DECAY_S = 0.9  # time in which the echo of a narrow place falls by 60 dB
ECHOING = 2  # groups that echo: sea and fishes
CHANGE_S = 0.6  # time in which a place comes to sound like the next
WET, DULL = 0.5, 0.45  # level of the echo, and share of high tones that stone takes each time
GONE = 1e-7  # energy at which an echo has died away


class Reverberation:
    """Adds the echo of a place to groups of sounds."""

    def __init__(self, directions: Array) -> None:
        # Not by the low-frequency channel, nor by those that hold a direction.
        self._heard = np.array(directions.any(axis=1))
        self._lines = np.zeros((ECHOING, len(LINES), int(LINES.max())))
        self._states = np.zeros((ECHOING, len(LINES)))  # low-pass of each line
        self._at = 0  # samples so far
        self._room = 0.0
        self._energy = 0.0

    def add(self, groups: Array, room: float) -> None:
        """Add the echo to the first two `groups` (g, n, c) of a place with this `room`, 0 to 1."""
        number = groups.shape[1]
        before = self._room
        self._room += (room - before) * (1.0 - math.exp(-number / (CHANGE_S * RATE)))
        if max(before, self._room) < 0.01 and self._energy < GONE:
            return
        self._energy = _echo(
            groups, self._lines, self._states, self._at, before, self._room, self._heard
        )
        self._at += number


@kernel
def _echo(
    groups: Array, lines: Array, states: Array, at: int, before: float, room: float, heard: Array
) -> float:
    """Add the echo between two values of the room; return the energy that is left in the lines."""
    number, channels = groups.shape[1], groups.shape[2]
    kept = np.empty(len(LINES))
    for line in range(len(LINES)):
        kept[line] = 10.0 ** (-3.0 * LINES[line] / (DECAY_S * RATE))
    come, energy, spots = np.empty(len(LINES)), 0.0, np.empty(len(LINES), np.int64)
    for g in range(len(lines)):
        for line in range(len(LINES)):
            spots[line] = at % LINES[line]
        for k in range(number):
            enter = 0.0
            for c in range(channels):
                if heard[c]:
                    enter += groups[g, k, c]
            now = before + (k + 1.0) / number * (room - before)
            enter *= now / channels
            total = 0.0
            for line in range(len(LINES)):
                value = lines[g, line, spots[line]]
                states[g, line] += (1.0 - DULL) * (value - states[g, line])
                come[line] = kept[line] * states[g, line]
                total += come[line]
            total *= 2.0 / len(LINES)  # Householder's reflection keeps the energy
            for line in range(len(LINES)):
                value = enter + come[line] - total
                lines[g, line, spots[line]] = value
                spots[line] = spots[line] + 1 if spots[line] + 1 < LINES[line] else 0
                energy += value * value
            for c in range(channels):
                if heard[c]:
                    sign = 1.0 if c % 2 == 0 else -1.0
                    groups[g, k, c] += WET * (
                        come[c % 4] + 0.6 * come[(c + 2) % 4] + 0.3 * sign * come[(c + 1) % 4]
                    )
    return energy
