"""A quiet score: slow tones that follow depth, hour and mood of the sea.

Each voice may begin a note at the borders of its own slots of time. Chance, by the seed, decides
whether it does; the mood of that moment decides which note.
"""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.noise import uniform
from subsea.kernels import kernel
from subsea.sound.space import BLOCK, RATE
from subsea.state import LOOPING, RUSHING, SPAWNING, STALKING
from subsea.world.world import TICK_S, World

CALM, HUNT, COURTSHIP = range(3)
NOTE = np.int64(319)  # key of the random numbers
WITHIN_CM = 1500.0  # distance of fishes that set the mood
DEEP_CM = 1500.0  # depth at which the score is lowest

# Scales, semitones above the root: pentatonic, Phrygian and Lydian.
SCALES = np.array([[0, 2, 4, 7, 9], [0, 1, 5, 7, 8], [2, 4, 6, 9, 11]])
ROOT_HZ = 110.0
NIGHT_SEMITONES, DEEP_SEMITONES = -5.0, -7.0
# Voices: slots, s; lowest octave; chance of a note in a slot, by mood; level.
SLOTS_S = np.array([19.0, 11.3, 7.9, 5.3])
OCTAVES = np.array([-1.0, 0.0, 1.0, 2.0])
CHANCES = np.array([[0.75, 0.6, 0.45, 0.25], [0.95, 0.5, 0.15, 0.0], [0.75, 0.7, 0.6, 0.5]])
LOUDNESS = np.array([1.0, 0.7, 0.45, 0.22])
OVERLAP = 1.7  # length of a note over that of its slot
BEATING_HZ = 0.35  # between the two tones of a note
SECOND, THIRD = 0.22, 0.08  # levels of the overtones
# The score's greatest level over that of everything else, and times, s, of its stepping back.
MOST_OF_SEA = 0.5
USUAL_S, RECENT_S, STEPS_BACK_S, FALLS_S, RETURNS_S = 4.0, 1.0, 0.8, 0.12, 1.5
NOTE_COLUMNS = ("age", "length", "hz", "level", "right", "phase", "other phase")


class Mood(NamedTuple):
    """The mood of the sea, which the score follows."""

    kind: int = CALM
    depth: float = 0.0  # 0 at the surface to 1
    daylight: float = 1.0  # 0 at night to 1


def mood_of(world: World, depth: float, away: Array) -> Mood:
    """Find the mood of the sea around a listener at a `depth`, cm; fishes are `away` (n,) cm."""
    minds, kind = world.state.minds, CALM
    near = world.state.fishes.alive & (away < WITHIN_CM)
    if (near & ((minds.hunt == STALKING) | (minds.hunt == RUSHING))).any():
        kind = HUNT
    elif (near & (minds.courtship >= LOOPING) & (minds.courtship <= SPAWNING)).any():
        kind = COURTSHIP
    return Mood(kind, min(depth / DEEP_CM, 1.0), float(world.state.sea.sky[1]))


class Score:
    """Plays the score, tick by tick."""

    def __init__(self) -> None:
        self._notes = np.zeros((2 * len(SLOTS_S), len(NOTE_COLUMNS)))

    def play(self, tick: int, seed: int, mood: Mood) -> Array:
        """Return the samples (2, BLOCK) of a tick for the left and the right, about 0.3 at most."""
        out = np.zeros((2, BLOCK))
        _begin_notes(self._notes, tick, seed, *mood)
        _add_notes(self._notes, out)
        return out


@kernel
def _begin_notes(
    notes: Array, tick: int, seed: int, kind: int, depth: float, daylight: float
) -> None:
    """Begin the notes whose slots begin in a tick."""
    end = tick * TICK_S
    for voice in range(len(SLOTS_S)):
        slot = math.floor(end / SLOTS_S[voice])
        if math.floor((end - TICK_S) / SLOTS_S[voice]) == slot:
            continue
        note = notes[2 * voice + slot % 2]
        key = 8 * voice
        if uniform(seed, key, slot, NOTE) >= CHANCES[kind, voice]:
            continue
        degree = int(uniform(seed, key + 1, slot, NOTE) * SCALES.shape[1])
        if voice == 0:
            degree = 0 if degree < 3 else 3  # the root, or its fifth or sixth
        pitch = SCALES[kind, degree] + 12.0 * OCTAVES[voice]
        pitch += math.floor(NIGHT_SEMITONES * (1.0 - daylight) + 0.5)
        pitch += math.floor(DEEP_SEMITONES * depth + 0.5)
        note[0], note[1] = 0.0, OVERLAP * SLOTS_S[voice]
        note[2] = ROOT_HZ * 2.0 ** (pitch / 12.0)
        note[3] = LOUDNESS[voice] * (0.6 + 0.4 * uniform(seed, key + 2, slot, NOTE))
        note[4] = 1.4 * uniform(seed, key + 3, slot, NOTE) - 0.7
        note[5], note[6] = uniform(seed, key + 4, slot, NOTE), uniform(seed, key + 5, slot, NOTE)


@kernel
def _add_notes(notes: Array, out: Array) -> None:
    """Add a block of all notes that sound to `out` (2, BLOCK), and let them grow older."""
    number = out.shape[1]
    for note in notes:
        if note[1] <= 0.0 or note[0] >= note[1]:
            continue
        swell = math.pi / (note[1] * RATE)
        begin = math.pi * note[0] / note[1]
        side = 0.25 * math.pi * (1.0 + note[4])
        left, right = math.cos(side), math.sin(side)
        for tone in range(2):
            hz = note[2] + (tone - 0.5) * BEATING_HZ
            turn = 2.0 * math.pi * hz / RATE
            c, s = math.cos(turn), math.sin(turn)
            x, y = (
                math.cos(2.0 * math.pi * note[5 + tone]),
                math.sin(2.0 * math.pi * note[5 + tone]),
            )
            level = 0.06 * note[3]
            ec, es = math.cos(swell), math.sin(swell)
            ex, ey = math.cos(begin), math.sin(begin)
            for k in range(number):
                x, y = c * x - s * y, s * x + c * y
                ex, ey = ec * ex - es * ey, es * ex + ec * ey
                # Overtones by sin 2a = 2 sin a cos a and sin 3a = sin a (4 cos² a - 1).
                value = y * (1.0 + SECOND * 2.0 * x + THIRD * (4.0 * x * x - 1.0))
                value *= level * max(ey, 0.0) ** 2
                out[0, k] += left * value
                out[1, k] += right * value
            note[5 + tone] = (note[5 + tone] + hz * number / RATE) % 1.0
        note[0] += number / RATE


class Ducking:
    """Keeps the score below the sounds of the sea, and lets it step back for loud ones."""

    def __init__(self) -> None:
        # Power of the others: loud moments, recent and usual; power of the score; last gain.
        self._states = np.zeros(5)

    def gains(self, played: Array, others: Array) -> Array:
        """Return gains (n,) for the score `played` (n, c) over `others` (n, c)."""
        fast, recent, slow, own, before = self._states.tolist()
        loud, mine = float((others**2).mean()), float((played**2).mean())
        fast = max(loud, fast + (loud - fast) * _share(STEPS_BACK_S))
        recent += (loud - recent) * _share(RECENT_S)
        slow += (loud - slow) * _share(USUAL_S)
        own = max(mine, own + (mine - own) * _share(USUAL_S))
        most = MOST_OF_SEA * math.sqrt(min(slow, recent) / max(own, 1e-12))
        gain = min(most, 1.0) / (1.0 + max(fast / max(slow, 1e-12) - 3.0, 0.0) / 3.0)
        gain = before + (gain - before) * _share(RETURNS_S if gain > before else FALLS_S)
        self._states[:] = fast, recent, slow, own, gain
        return before + (gain - before) * (np.arange(len(played)) + 1.0) / len(played)


def _share(seconds: float) -> float:
    """Share of a change that is made in a tick."""
    return 1.0 - math.exp(-TICK_S / seconds)
