"""Captures of prey in company and alone."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.vector import minus, norm, vector
from subsea.kernels import kernel
from subsea.lab.series import SAMPLE_S
from subsea.media.record import Record
from subsea.state import PREY

COMPANIONS, COMPANY_BL = 2, 2.5  # in company: at least 2 of its species within this distance
BEFORE_S = 3.0  # decisive period before a capture


class Captures(NamedTuple):
    """Prey in company and alone: time spent so, and number caught."""

    lost: int  # fishes that died or were landed, of any kind
    caught: tuple[int, int]  # prey in company, and alone, for most of the three seconds before
    exposed_s: tuple[float, float]  # fish-seconds of prey in company, and alone


def captures(record: Record) -> Captures:
    """Count caught prey in company (two of its species within 2.5 body lengths) and alone."""
    every = max(round(SAMPLE_S / record.tick_s), 1)
    prey = np.flatnonzero(record.kind == PREY)
    last, fishes = np.nonzero(record.alive[:-1] & ~record.alive[1:])
    company = np.zeros((len(range(0, len(record.time), every)), len(prey)), np.bool_)
    alive = record.alive[::every][:, prey]
    if len(prey) > COMPANIONS:
        _company(
            record.position[::every][:, prey], alive, record.species[prey], record.length[prey],
            company,
        )  # fmt: skip
    back = max(round(BEFORE_S / SAMPLE_S), 1)
    caught = [0, 0]
    for t, i in zip(last, fishes, strict=True):
        if record.kind[i] == PREY:
            k = t // every
            before = company[max(k - back + 1, 0) : k + 1, np.searchsorted(prey, i)]
            caught[0 if 2 * before.sum() > len(before) else 1] += 1
    second = every * record.tick_s
    exposed = ((company & alive).sum() * second, (~company & alive).sum() * second)
    return Captures(len(last), (caught[0], caught[1]), (float(exposed[0]), float(exposed[1])))


@kernel
def _company(position: Array, alive: Bools, species: Ints, length: Array, company: Bools) -> None:
    n = len(species)
    count, farthest = np.empty(n, np.int64), COMPANY_BL * length.max()
    for t in range(len(position)):
        count[:] = 0
        order = np.argsort(position[t, :, 0], kind="mergesort")
        for a in range(n):
            i = order[a]
            for b in range(a + 1, n):
                j = order[b]
                if position[t, j, 0] - position[t, i, 0] > farthest:
                    break
                if species[i] != species[j] or not alive[t, i] or not alive[t, j]:
                    continue
                gap = norm(minus(vector(position[t, j]), vector(position[t, i])))
                if gap <= COMPANY_BL * 0.5 * (length[i] + length[j]):
                    count[i] += 1
                    count[j] += 1
        company[t] = (count >= COMPANIONS) & alive[t]
