"""Sounds of single events, as one channel: all are synthesised.

Bubbles follow Minnaert, snaps of shrimp the band that was measured on reefs. All others are
designed: `docs/explanation/sound.md`.
"""

import math
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.noise import uniform
from subsea.kernels import kernel
from subsea.sound.space import RATE

SNAP, BUBBLE, POP, CRUNCH, WHOOSH, STRIKE, KNOCK, CREAK = range(8)
LONGEST = RATE  # samples of any sound
GAMMA, AIR_PA, WATER_KG_M3, GRAVITY = 1.4, 101_325.0, 1025.0, 9.81
RINGS = 18.0  # oscillations in which a bubble fades by a factor e, about those of 1 to 5 mm
GLIDE = 0.8  # 1/s: by how much a bubble that rises and shrinks from its ring goes up
NOISE = np.int64(300)  # key of the random numbers


@kernel
def minnaert_hz(radius_cm: float, depth_cm: float) -> float:
    """Resonance of a bubble: f = 1/(2πa) √(3γP/ρ) (Minnaert 1933)."""
    pressure = AIR_PA + WATER_KG_M3 * GRAVITY * 0.01 * depth_cm
    return math.sqrt(3.0 * GAMMA * pressure / WATER_KG_M3) / (2.0 * math.pi * 0.01 * radius_cm)


@kernel
def noise_seed(seed: int, key: int) -> int:
    """The state with which a noise begins."""
    return int(uniform(seed, key, 0, NOISE) * 9.0e15) + 1


@kernel
def next_noise(state: int) -> Any:
    """The state after a sample (Marsaglia's xorshift)."""
    z = np.uint64(state)
    z ^= z << np.uint64(13)
    z ^= z >> np.uint64(7)
    z ^= z << np.uint64(17)
    return np.int64(z)


@kernel
def white(state: int) -> float:
    """The sample of a noise in a state, in [-1, 1)."""
    return float(state) * 2.0**-63


@kernel
def one_pole(corner_hz: float) -> float:
    """Share by which a one-pole low-pass follows its input in a sample."""
    return 1.0 - math.exp(-2.0 * math.pi * min(corner_hz, 0.49 * RATE) / RATE)


@kernel
def sing(kind: int, size: float, pitch: float, seed: int, out: Array) -> int:
    """Write an event at a level of about 1 to `out`, and return its number of samples.

    `size` is the resonance of a bubble, Hz; `pitch` is a factor on all frequencies.
    """
    if kind == SNAP:
        return _snap(pitch, seed, out)
    if kind == BUBBLE:
        return _ring(size * pitch, out)
    if kind == POP:
        return _pop(pitch, seed, out)
    if kind == CRUNCH:
        return _crunch(pitch, seed, out)
    if kind == WHOOSH:
        return _rush(0.4, 90.0 * pitch, 600.0 * pitch, seed, out)
    if kind == STRIKE:
        return _strike(pitch, seed, out)
    if kind == KNOCK:
        return _knock(pitch, out)
    return _creak(pitch, seed, out)


@kernel
def _add_damped(hz: float, fade_s: float, level: float, number: int, out: Array) -> None:
    """Add a damped oscillation to `number` samples."""
    turn = 2.0 * math.pi * hz / RATE
    twice, shrink = 2.0 * math.cos(turn), math.exp(-1.0 / (fade_s * RATE))
    before, now, loud = -math.sin(turn), 0.0, level
    for k in range(number):
        out[k] += loud * now
        before, now = now, twice * now - before
        loud *= shrink


@kernel
def _snap(pitch: float, seed: int, out: Array) -> int:
    """The collapse of a bubble at a shrimp's claw: a click of 2 to 15 kHz, a millisecond long."""
    hz = pitch * (4000.0 + 5000.0 * uniform(seed, 1, 0, NOISE))
    fade = 1.6e-4 + 2.0e-4 * uniform(seed, 2, 0, NOISE)
    number = int(8.0 * fade * RATE)
    out[:number] = 0.0
    _add_damped(hz, fade, 1.0, number, out)
    _add_damped(1.9 * hz, 0.6 * fade, 0.6, number, out)
    return number


@kernel
def _ring(hz: float, out: Array) -> int:
    """A bubble that leaves: a damped oscillation at `hz`, which glides up."""
    fade = RINGS / (math.pi * hz)
    number = min(int(6.0 * fade * RATE), LONGEST)
    loud, shrink = 1.0, math.exp(-1.0 / (fade * RATE))
    for k in range(number):
        t = k / RATE
        begin = min(t * hz, 1.0)  # no click
        out[k] = begin * loud * math.sin(2.0 * math.pi * hz * t * (1.0 + 0.5 * GLIDE * t))
        loud *= shrink
    return number


@kernel
def _pop(pitch: float, seed: int, out: Array) -> int:
    """A mouth that opens around a speck."""
    hz = pitch * (350.0 + 450.0 * uniform(seed, 1, 0, NOISE))
    number, state = int(0.03 * RATE), noise_seed(seed, 0)
    out[:number] = 0.0
    _add_damped(hz, 0.004, 1.0, number, out)
    hiss, shrink = 0.15, math.exp(-1.0 / (0.002 * RATE))
    for k in range(number):
        state = next_noise(state)
        out[k] = min(k / (0.001 * RATE), 1.0) * (out[k] + hiss * white(state))
        hiss *= shrink
    return number


@kernel
def _crunch(pitch: float, seed: int, out: Array) -> int:
    """Teeth on coral: a few short bursts of noise within a sixth of a second."""
    number = int(0.18 * RATE)
    out[:number] = 0.0
    for b in range(5 + int(4.0 * uniform(seed, 0, 0, NOISE))):
        first = int(0.15 * RATE * uniform(seed, b, 1, NOISE))
        loud = 2.4 * (0.4 + 0.6 * uniform(seed, b, 2, NOISE))
        shrink = math.exp(-1.0 / (0.004 * RATE))
        for k in range(first, number):
            out[k] += min((k - first) / (0.0006 * RATE), 1.0) * loud
            loud *= shrink
    _band(900.0 * pitch, 5500.0 * pitch, number, seed, out)
    return number


@kernel
def _band(from_hz: float, to_hz: float, number: int, seed: int, out: Array) -> None:
    """Multiply samples by noise in a band."""
    low, lower, high, state = 0.0, 0.0, 0.0, noise_seed(seed, 0)
    fast, slow = one_pole(to_hz), one_pole(from_hz)
    for k in range(number):
        state = next_noise(state)
        low += fast * (white(state) - low)
        lower += fast * (low - lower)
        high += slow * (lower - high)
        out[k] *= lower - high


@kernel
def _rush(seconds: float, from_hz: float, to_hz: float, seed: int, out: Array) -> int:
    """Water thrown aside: a swell of noise in a band."""
    number = int(seconds * RATE)
    for k in range(number):
        share = k / number
        out[k] = 9.0 * math.sin(math.pi * share) ** 2 * (1.0 - 0.5 * share)
    _band(from_hz, to_hz, number, seed, out)
    return number


@kernel
def _strike(pitch: float, seed: int, out: Array) -> int:
    """Jaws that close: a low thump that falls, and a rush."""
    number = _rush(0.45, 70.0 * pitch, 900.0 * pitch, seed, out)
    for k in range(number):
        t = k / RATE
        begin = min(t / 0.004, 1.0)
        thump = math.sin(2.0 * math.pi * pitch * (38.0 * t + 1.6 * (1.0 - math.exp(-t / 0.05))))
        out[k] = 0.6 * out[k] + begin * math.exp(-t / 0.09) * thump
    return number


@kernel
def _knock(pitch: float, out: Array) -> int:
    """A hull that touches stone."""
    number = int(0.5 * RATE)
    out[:number] = 0.0
    for hz, fade, level in ((82.0, 0.11, 0.6), (203.0, 0.05, 0.4), (391.0, 0.02, 0.3)):
        _add_damped(hz * pitch, fade, level, number, out)
    return number


@kernel
def _creak(pitch: float, seed: int, out: Array) -> int:
    """A hull that settles at another depth: plates stick and slip, faster and faster."""
    number, first, slips = int(0.8 * RATE), 0.0, 0
    hz = pitch * (420.0 + 380.0 * uniform(seed, 1, 0, NOISE))
    rate = 28.0 + 30.0 * uniform(seed, 2, 0, NOISE)
    out[:number] = 0.0
    while int(first) < number - int(0.05 * RATE):
        share = first / number
        level = math.sin(math.pi * share) ** 0.5 * (0.5 + 0.5 * uniform(seed, slips, 3, NOISE))
        begin = int(first)
        _add_damped(hz, 0.006, level, int(0.05 * RATE), out[begin:])
        first += RATE / (rate * (1.0 + 0.7 * share))
        slips += 1
    return number
