"""Move fins and mouth of a fish that plays a segment, as in the dive (`motor/fins.py`).

In the dive fins, mouth and tail beat at different rates. A cyclic clip must close: it lasts as many
beats of the tail as fit best, and fins and mouth beat a little faster or slower.
"""

from itertools import product

import numpy as np

from subsea.base.arrays import Array
from subsea.fish.species import Species
from subsea.motor.controller import CSTART_TEMPO
from subsea.motor.fins import flap
from subsea.motor.playback import FAST, SIDES, SLOW, STOP, is_cstart
from subsea.repertoire import SEGMENTS, Repertoire
from subsea.repertoire.library import pack
from subsea.state import Fishes, empty
from subsea.world.populate import FLAT_BL
from subsea.world.repertoires import coupling_of

MOST_BEATS = 4  # of the tail in a cyclic clip
NEAR = 0.2  # change of the rate of fins and mouth that is small enough
TRIAL_S = 1e-3  # to measure their rates
LONG_S = 10.0  # in which the fins that do not beat come to rest


class FinPlayer:
    """A fish without a sea, whose fins the dive moves."""

    def __init__(self, species: Species, repertoire: Repertoire, scale: float) -> None:
        """Make a fish; `scale` is its size over that of the recorded fish."""
        self._library = pack([repertoire], [coupling_of(species, repertoire)])
        self._fishes = fishes = empty(Fishes, n=1)
        fishes.scale[:], fishes.size_rate[:] = scale, 1.0 / np.sqrt(scale)
        fishes.oars[:] = species.surface.depth > FLAT_BL
        fishes.flaps[:] = species.row is not None and species.row.flaps
        self._row_s = repertoire.tick_s * np.sqrt(scale) / species.pace

    def clip(self, name: str) -> tuple[int, Array]:
        """Count the beats of the tail in a clip of a segment; compute its fins (T, 14).

        Columns are those of `state.Fishes.fins`. A cyclic clip ends as it begins.
        """
        segment = SEGMENTS.index(name)
        rows = int(self._library.length[0, segment])
        if not self._library.cyclic[0, segment]:
            self._begin(SLOW, self._share(SLOW if segment == STOP else segment))
            self._step(0, LONG_S)
            return 1, self._run(segment, rows)
        self._begin(segment, self._share(segment))
        cycles = self._rates() * rows * self._row_s / (2.0 * np.pi)  # in a beat of the tail
        # Waves are so fast that they fit any number of beats.
        beats, whole = _fitted(cycles[[0, 1, 3]])
        whole = np.insert(whole, 2, max(np.round(beats * cycles[2]), 1.0))
        self._step(0, LONG_S)
        out = [
            self._at(row, 2.0 * np.pi * whole * (beat + row / rows) / beats)
            for beat, row in product(range(beats), range(rows))
        ]
        return beats, np.array([*out, out[0]])

    def _share(self, segment: int) -> float:
        """Return the speed that a fish wants in a segment, as a share of its fast swim."""
        if segment == STOP:
            return 0.0
        speed = self._library.speed[0]
        return 1.0 if is_cstart(segment) else float(np.clip(speed[segment] / speed[FAST], 0.0, 1.0))

    def _begin(self, segment: int, share: float) -> None:
        fishes = self._fishes
        fishes.segment[:], fishes.goal_speed[:], fishes.thrust[:] = segment, share, 1.0
        fishes.velocity[0, 0], fishes.bend[:] = share * fishes.fast[0], SIDES[segment]
        fishes.tempo[:] = CSTART_TEMPO if is_cstart(segment) else 1.0
        fishes.fin_phase[:], fishes.breath[:] = 0.0, 0.0

    def _rates(self) -> Array:
        """Measure the rates of left fin, right fin, wave and breath, rad/s."""
        self._step(0, TRIAL_S)
        fishes = self._fishes
        turned = np.array([*fishes.fin_phase[0], fishes.breath[0]], np.float64)
        return np.asarray(((turned + np.pi) % (2.0 * np.pi) - np.pi) / TRIAL_S)

    def _run(self, segment: int, rows: int) -> Array:
        """Compute the fins in all frames of a segment that is played once."""
        fishes = self._fishes
        fishes.segment[:] = segment
        fishes.tempo[:] = CSTART_TEMPO if is_cstart(segment) else 1.0
        fishes.fin_phase[:], fishes.breath[:] = 0.0, 0.0
        fishes.goal_speed[:] = self._share(segment)
        out = []
        for row in range(rows):
            if segment == STOP:
                fishes.thrust[:] = 1.0 - row / (rows - 1)
            out.append(self._step(row, self._row_s if row else 0.0))
        return np.array(out)

    def _at(self, row: int, phases: Array) -> Array:
        """Compute the fins at phases of left fin, right fin, wave and breath."""
        self._fishes.fin_phase[0] = phases[:3]
        self._fishes.breath[0] = phases[3]
        return self._step(row, 0.0)

    def _step(self, row: int, seconds: float) -> Array:
        fishes, segment = self._fishes, int(self._fishes.segment[0])
        first = int(self._library.first[0, segment])
        fishes.row_a[0] = first + row
        fishes.row_b[0] = self._library.follow[first + row]
        flap(np.zeros(1, np.int64), fishes, self._library, seconds)
        return np.array(fishes.fins[0], np.float64)


def _fitted(cycles: Array) -> tuple[int, Array]:
    """Find the fewest beats in which all cycles are nearly whole, and the numbers of cycles.

    `cycles` are those in one beat.
    """
    best, least, whole = 1, np.inf, np.zeros_like(cycles)
    for beats in range(1, MOST_BEATS + 1):
        wanted = beats * cycles
        fitting = np.where(
            np.abs(cycles) < 1e-3, 0.0, np.sign(wanted) * np.maximum(np.round(np.abs(wanted)), 1.0)
        )
        off = float(np.abs(fitting / np.where(wanted == 0.0, 1.0, wanted) - 1.0)[fitting != 0].max(
            initial=0.0
        ))  # fmt: skip
        if off < least:
            best, least, whole = beats, off, fitting
        if off <= NEAR:
            break
    return best, whole
