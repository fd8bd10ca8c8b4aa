"""Mix the moments of a dive to the channels of a layout, a tick at a time."""

import math
from dataclasses import dataclass

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.noise import uniform
from subsea.kernels import kernel
from subsea.sound.ambience import SLOW, wander
from subsea.sound.moment import (
    BEDS,
    BREATH,
    CRACKLE,
    GROUP_OF_BED,
    GROUP_OF_VOICE,
    LAP,
    MOTOR,
    SAND,
    SCORE,
    SURF,
    WINCH,
    Moment,
)
from subsea.sound.reverberation import Reverberation
from subsea.sound.score import Ducking, Score
from subsea.sound.space import BLOCK, RATE, Layout, muffling, pan, reach_ears
from subsea.sound.voices import LONGEST, next_noise, noise_seed, one_pole, sing, white

# Noise of each bed: a band, Hz, and a factor that brings it to a level of about 1.
LOW_HZ = np.array([60, 1800, 70, 60, 60, 500, 600, 350, 2500, 30, 26.0])
HIGH_HZ = np.array([420, 15_000, 600, 200, 340, 2500, 3800, 2600, 9000, 85, 95.0])
RAISE = np.array([13, 8, 10, 3, 14, 1.2, 4.5, 5, 3, 40, 36.0])
HARMONICS = np.array([0.55, 0.30, 0.16, 0.10, 0.05, 0.04])  # of motor and winch
WAVES_S, SETS_S = 3.1, 7.9  # times in which single waves and sets of waves change
FAINT = 1e-5  # level of a bed below which nobody hears it
BREATH_S, CALM_S = 4.6, 9.0  # mean period of breath, and the time in which it changes
WANDER = 1.4  # breaths by which a breath comes early or late
LIFT = 2.7  # factor on all levels: seas have about -20 LUFS at the volume of films
# Greatest samples. Peaks between samples, and those of AAC, are up to 2 dB higher: below -1 dB.
MOST, MOST_AT_NIGHT = 0.65, 0.25
ATTACK_S, RELEASE_S = 0.001, 0.05  # of the gain before and after a peak
RAMP = (np.arange(BLOCK) + 1.0) / BLOCK
STATES = 4  # of a bed: phase, three filters
SPARSE = 0.99  # noise beyond which it counts as a snap afar: 480 a second


@dataclass(frozen=True)
class SoundLevels:
    """Volumes, 0 to 1, and what is left out."""

    volume: float = 0.8
    sea: float = 1.0
    fishes: float = 1.0
    vessel: float = 1.0
    score: float = 0.0
    mute: bool = False
    night: bool = False  # loud sounds are softer

    @property
    def gains(self) -> Array:
        """Factors (4,) on the GROUPS."""
        whole = 0.0 if self.mute else self.volume
        return whole * np.array([self.sea, self.fishes, self.vessel, self.score])


class Mixer:
    """Turns moments into samples. The first moment is heard without what was before it."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        channels = layout.channels
        self._rest = np.zeros((SCORE, LONGEST + 2 * BLOCK, channels))
        self._end = 0  # of what is left in it of earlier events, samples
        self._states = np.zeros((len(BEDS), STATES))
        self._before: tuple[Array, Array] | None = None  # beds and their gains
        self._gains: Array | None = None  # of the last tick
        self._limits = np.ones(2)  # gains at the end of the last tick: of the stems, at night
        self._room = Reverberation(layout.directions)
        self._score, self._ducking = Score(), Ducking()

    def stems(self, moment: Moment, scored: bool = False) -> Array:
        """The samples (g, BLOCK, c) of each of the GROUPS in a tick, at full volume.

        There are three of them, and the score if it is `scored`. A limiter holds the peaks of each,
        and of all together. It changes all by the same gain.
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
        self._room.add(out, moment.room)
        if scored:
            out = np.concatenate([out, self._play(moment, out)[None]])
        self._limits[0] = _limit(out, MOST, self._limits[0])
        return out

    def mix(self, moment: Moment, levels: SoundLevels) -> Array:
        """The samples (BLOCK, c) float32 of a tick, in [-1, 1]."""
        fades = self._gains is not None and self._gains[SCORE] > 0.0
        return self.blend(self.stems(moment, levels.gains[SCORE] > 0.0 or fades), levels)

    def blend(self, stems: Array, levels: SoundLevels) -> Array:
        """As `mix`, from the `stems` of the tick; volumes change without a click."""
        gains = levels.gains
        before = gains if self._gains is None else self._gains
        ramp = before + RAMP[:, None] * (gains - before)
        self._gains = gains
        whole = np.einsum("gnc,ng->nc", stems, ramp[:, : len(stems)])
        if levels.night:
            self._limits[1] = _limit(whole[None], MOST_AT_NIGHT, self._limits[1])
        return np.asarray(whole, np.float32)

    def _play(self, moment: Moment, others: Array) -> Array:
        """The samples (BLOCK, c) of the score, below the `others` (3, BLOCK, c)."""
        sides = self._score.play(moment.tick, moment.seed, moment.mood)
        gains = np.zeros((2, self.layout.channels))
        for gain, right in zip(gains, (-0.9, 0.9), strict=True):
            pan(self.layout.directions, self.layout.width, (right, 0.4, 0.0), gain)
        played = sides.T @ gains
        return played * self._ducking.gains(played, others.sum(axis=0))[:, None]

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
        if old[b, 0] <= FAINT and new[b, 0] <= FAINT:
            continue
        group, tonal = GROUP_OF_BED[b], b in (MOTOR, WINCH)
        low, high = one_pole(LOW_HZ[b]), one_pole(HIGH_HZ[b])
        noise = noise_seed(seed + 7919 * (b + 1), first)
        if tonal:
            states[b, 0] = _hum(old[b, 4], new[b, 4], states[b, 0], tones)
        before, now = old[b, 0], new[b, 0]
        if b == SURF:
            before, now = before * _swell(seed, begin), now * _swell(seed, end)
        elif b in (LAP, SAND):  # water runs with the same waves, a little later
            before *= _swell(seed, begin - 0.8) ** 2
            now *= _swell(seed, end - 0.8) ** 2
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
    number = len(out)
    rise = (new_hz - old_hz) / number
    begin, step = 2.0 * math.pi * phase, 2.0 * math.pi * old_hz / RATE
    bend = 2.0 * math.pi * rise / RATE
    x, y = math.cos(begin), math.sin(begin)
    c, s = math.cos(step), math.sin(step)  # rotation in a sample, which turns by `bend` in each
    cc, ss = math.cos(bend), math.sin(bend)
    for k in range(number):
        c, s = cc * c - ss * s, ss * c + cc * s
        x, y = c * x - s * y, s * x + c * y
        before, now, total = 0.0, y, 0.0
        for level in HARMONICS:
            total += level * now
            before, now = now, 2.0 * x * now - before
        out[k] = total
    return (phase + (number * old_hz + 0.5 * (number + 1.0) * number * rise) / RATE) % 1.0


@kernel
def _swell(seed: int, t: float) -> float:
    """Return the level of waves that come and go, in no rhythm."""
    return 0.3 + 0.42 * wander(seed, t / WAVES_S, 0) + 0.28 * wander(seed, t / SETS_S, 1)


@kernel
def _breath(seed: int, t: float) -> float:
    """Breathing in, briefly, and out, longer and softer; no breath is like the last."""
    breaths = t / BREATH_S + WANDER * wander(seed, t / CALM_S, 2)
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
