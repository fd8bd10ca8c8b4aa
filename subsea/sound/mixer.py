"""Mix the moments of a dive to the channels of a layout, a tick at a time."""

import math
from dataclasses import dataclass

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.noise import uniform
from subsea.kernels import kernel
from subsea.sound.moment import (
    BEDS,
    BREATH,
    CRACKLE,
    GROUP_OF_BED,
    GROUP_OF_VOICE,
    GROUPS,
    MOTOR,
    SURF,
    WINCH,
    Moment,
)
from subsea.sound.space import BLOCK, RATE, Layout, muffling, pan, reach_ears
from subsea.sound.voices import LONGEST, next_noise, noise_seed, one_pole, sing, white

# Noise of each bed: a band, Hz, and a factor that brings it to a level of about 1.
LOW_HZ = np.array([60.0, 1800.0, 70.0, 60.0, 60.0, 500.0, 600.0])
HIGH_HZ = np.array([420.0, 15_000.0, 600.0, 200.0, 340.0, 2500.0, 3800.0])
RAISE = np.array([13.0, 8.0, 10.0, 3.0, 14.0, 1.2, 4.5])
HARMONICS = np.array([0.55, 0.30, 0.16, 0.10, 0.05, 0.04])  # of motor and winch
WAVES_S, SETS_S = 3.1, 7.9  # times in which single waves and sets of waves change
BREATH_S, CALM_S = 4.6, 9.0  # mean period of breath, and the time in which it changes
WANDER = 1.4  # breaths by which a breath comes early or late
LIFT = 2.7  # factor on all levels: seas have about -20 LUFS at the volume of films
# Greatest samples. Peaks between samples, and those of AAC, are up to 2 dB higher: below -1 dB.
MOST, MOST_AT_NIGHT = 0.65, 0.25
ATTACK_S, RELEASE_S = 0.001, 0.05  # of the gain before and after a peak
RAMP = (np.arange(BLOCK) + 1.0) / BLOCK
STATES = 4  # of a bed: phase, three filters
SLOW = np.int64(318)  # key of the random numbers of waves and breath
SPARSE = 0.99  # noise beyond which it counts as a snap afar: 480 a second


@dataclass(frozen=True)
class SoundLevels:
    """Volumes, 0 to 1, and what is left out."""

    volume: float = 0.8
    sea: float = 1.0
    fishes: float = 1.0
    vessel: float = 1.0
    mute: bool = False
    night: bool = False  # loud sounds are softer

    @property
    def gains(self) -> Array:
        """Factors (3,) on the groups."""
        whole = 0.0 if self.mute else self.volume
        return whole * np.array([self.sea, self.fishes, self.vessel])


class Mixer:
    """Turns moments into samples. The first moment is heard without what was before it."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        channels = layout.channels
        self._rest = np.zeros((len(GROUPS), LONGEST + 2 * BLOCK, channels))
        self._end = 0  # of what is left in it of earlier events, samples
        self._states = np.zeros((len(BEDS), STATES))
        self._before: tuple[Array, Array] | None = None  # beds and their gains
        self._gains: Array | None = None  # of the last tick
        self._limits = np.ones(2)  # gains at the end of the last tick: of the stems, at night

    def stems(self, moment: Moment) -> Array:
        """The samples (3, BLOCK, c) of each of the GROUPS in a tick, at full volume.

        A limiter holds the peaks of each, and of all together. It changes all by the same gain.
        """
        gains = np.zeros((len(BEDS), self.layout.channels))
        _place_beds(moment.beds, *self._where, gains)
        before = self._before or (moment.beds, gains)
        self._before = moment.beds, gains
        first = (moment.tick - 1) * BLOCK
        _add_beds(self._rest, *before, moment.beds, gains, self._states, first, moment.seed)
        end = _add_events(self._rest, moment.events, *self._where, self.layout.delay_s)
        end = max(end, self._end, BLOCK)
        out = self._rest[:, :BLOCK].copy()
        self._rest[:, : end - BLOCK] = self._rest[:, BLOCK:end]
        self._rest[:, end - BLOCK : end] = 0.0
        self._end = end - BLOCK
        self._limits[0] = _limit(out, MOST, self._limits[0])
        return out

    def mix(self, moment: Moment, levels: SoundLevels) -> Array:
        """The samples (BLOCK, c) float32 of a tick, in [-1, 1]."""
        return self.blend(self.stems(moment), levels)

    def blend(self, stems: Array, levels: SoundLevels) -> Array:
        """As `mix`, from the `stems` of the tick; volumes change without a click."""
        gains = levels.gains
        before = gains if self._gains is None else self._gains
        ramp = before + RAMP[:, None] * (gains - before)
        self._gains = gains
        whole = np.einsum("gnc,ng->nc", stems, ramp)
        if levels.night:
            self._limits[1] = _limit(whole[None], MOST_AT_NIGHT, self._limits[1])
        return np.asarray(whole, np.float32)

    @property
    def _where(self) -> tuple[Array, float]:
        return self.layout.directions, self.layout.width


@kernel
def _limit(groups: Array, most: float, gain: float) -> float:
    """Limit the sum of any of the `groups` (g, n, c) to `most`, in place; return the last gain.

    The gain falls before a peak and recovers after it, beginning with `gain`. It only falls at once
    for a peak in the first millisecond.
    """
    number = groups.shape[1]
    gains = np.empty(number)
    recover, fall = 1.0 - math.exp(-1.0 / (RELEASE_S * RATE)), 1.0 / (ATTACK_S * RATE)
    for k in range(number):
        peak = most
        for c in range(groups.shape[2]):
            above, below = 0.0, 0.0  # the largest sums with any volumes
            for g in range(len(groups)):
                above += max(groups[g, k, c], 0.0)
                below -= min(groups[g, k, c], 0.0)
            peak = max(peak, above, below)
        gain = min(gain + recover * (1.0 - gain), most / peak)
        gains[k] = gain
    after = gain
    for k in range(number - 1, -1, -1):
        after = min(gains[k], after + fall)
        for g in range(len(groups)):
            for c in range(groups.shape[2]):
                groups[g, k, c] *= after
    return gain


@kernel
def _place_beds(beds: Array, directions: Array, width: float, gains: Array) -> None:
    """Write the gains (b, c) of each bed and channel."""
    for b in range(len(beds)):
        pan(directions, width, (beds[b, 1], beds[b, 2], beds[b, 3]), gains[b])


@kernel
def _add_beds(
    out: Array, old: Array, old_gains: Array, new: Array, gains: Array, states: Array,
    first: int, seed: int,
) -> None:  # fmt: skip
    """Add all beds to the groups of `out` (3, n, c) from the `old` to the `new` levels."""
    begin, end = first / RATE, (first + BLOCK) / RATE
    tones = np.empty(BLOCK)
    for b in range(len(new)):
        if old[b, 0] == 0.0 and new[b, 0] == 0.0:
            continue
        group, tonal = GROUP_OF_BED[b], b in (MOTOR, WINCH)
        low, high = one_pole(LOW_HZ[b]), one_pole(HIGH_HZ[b])
        noise = noise_seed(seed + 7919 * (b + 1), first)
        if tonal:
            states[b, 0] = _hum(old[b, 4], new[b, 4], states[b, 0], tones)
        before, now = old[b, 0], new[b, 0]
        if b == SURF:
            before, now = before * _swell(seed, begin), now * _swell(seed, end)
        elif b == BREATH:
            before, now = before * _breath(seed, begin), now * _breath(seed, end)
        faster, fast, slow, raised = states[b, 1], states[b, 2], states[b, 3], LIFT * RAISE[b]
        for k in range(BLOCK):
            noise = next_noise(noise)
            value = white(noise)
            if b == CRACKLE:  # far snaps
                value = value if abs(value) > SPARSE else 0.0
            faster += high * (value - faster)
            fast += high * (faster - fast)
            slow += low * (fast - slow)
            value = raised * (fast - slow)
            if tonal:
                value = 0.25 * value + LIFT * tones[k]
            share = (k + 1.0) / BLOCK
            value *= before + share * (now - before)
            for c in range(gains.shape[1]):
                out[group, k, c] += value * (
                    old_gains[b, c] + share * (gains[b, c] - old_gains[b, c])
                )
        states[b, 1], states[b, 2], states[b, 3] = faster, fast, slow


@kernel
def _hum(old_hz: float, new_hz: float, phase: float, out: Array) -> float:
    """Write a tone and its harmonics from one pitch to another; returns the phase at the end."""
    for k in range(len(out)):
        hz = old_hz + (k + 1.0) / len(out) * (new_hz - old_hz)
        phase = (phase + hz / RATE) % 1.0
        before, now = 0.0, math.sin(2.0 * math.pi * phase)
        twice = 2.0 * math.cos(2.0 * math.pi * phase)
        out[k] = 0.0
        for level in HARMONICS:
            out[k] += level * now
            before, now = now, twice * now - before
    return phase


@kernel
def _wander(seed: int, t: float, key: int) -> float:
    """Return a smooth random function of time in [0, 1), with a number at each whole `t`."""
    number = math.floor(t)
    share = t - number
    eased = share * share * (3.0 - 2.0 * share)
    before, after = uniform(seed, key, number, SLOW), uniform(seed, key, number + 1, SLOW)
    return before + eased * (after - before)


@kernel
def _swell(seed: int, t: float) -> float:
    """Return the level of waves that come and go, in no rhythm."""
    return 0.3 + 0.42 * _wander(seed, t / WAVES_S, 0) + 0.28 * _wander(seed, t / SETS_S, 1)


@kernel
def _breath(seed: int, t: float) -> float:
    """Breathing in, briefly, and out, longer and softer; no breath is like the last."""
    breaths = t / BREATH_S + WANDER * _wander(seed, t / CALM_S, 2)
    number = math.floor(breaths)
    at, depth = breaths - number, 0.4 + 0.6 * uniform(seed, 3, number, SLOW)
    turn, end = (
        0.2 + 0.2 * uniform(seed, 4, number, SLOW),
        0.7 + 0.3 * uniform(seed, 5, number, SLOW),
    )
    if at < turn:
        return depth * math.sin(math.pi * at / turn) ** 2
    turn += 0.1
    if at < turn or at > end:
        return 0.0
    return depth * 0.55 * math.sin(math.pi * (at - turn) / (end - turn)) ** 2


VOICE_GROUPS = np.array([GROUP_OF_VOICE[voice] for voice in sorted(GROUP_OF_VOICE)])


@kernel
def _add_events(out: Array, events: Array, directions: Array, width: float, delay_s: float) -> int:
    """Add all events to the groups of `out` (3, n, c); returns the end of the last, samples."""
    end = 0
    channels = out.shape[2]
    sound = np.empty(LONGEST)
    gains, delays, corners = np.empty(channels), np.empty(channels), np.empty(channels)
    for e in range(len(events)):
        voice = int(events[e, 0])
        way = (events[e, 3], events[e, 4], events[e, 5])
        number = sing(voice, events[e, 7], events[e, 8], int(events[e, 9]), sound)
        pan(directions, width, way, gains)
        reach_ears(width, delay_s, way, delays, corners)
        group, water = VOICE_GROUPS[voice], one_pole(muffling(events[e, 6]))
        for c in range(channels):
            head = one_pole(corners[c])
            at = events[e, 1] * BLOCK + delays[c]
            start = int(at)
            part = at - start
            wet, heard = 0.0, 0.0
            gain = LIFT * events[e, 2] * gains[c]
            for k in range(number):
                wet += water * (sound[k] - wet)
                heard += head * (wet - heard)
                out[group, start + k, c] += gain * (1.0 - part) * heard
                out[group, start + k + 1, c] += gain * part * heard
            end = max(end, start + number + 1)
    return end
