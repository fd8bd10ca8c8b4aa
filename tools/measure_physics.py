"""Measure the simulated fish: the cost of a step, and the longest stable step.

.venv/bin/python tools/measure_physics.py [SPECIES...]
"""

import sys
from collections.abc import Callable

import numpy as np
from numba import njit
from scipy.linalg import solveh_banded

from capture.inspection.gait import fastest_us, step_cost
from capture.recording.trial import beat_contraction, steady_beat
from subsea.biomechanics.body import (
    HALF_BANDWIDTH,
    MUSCLES,
    NODES,
    Body,
    Floats,
    Material,
    build_body,
)
from subsea.biomechanics.controllers import muscle_lengths
from subsea.biomechanics.simulation import STILL, BodyState, at_rest, is_sound
from subsea.biomechanics.solver import ROWS, STEP, advance, assemble, factorize, substitute
from subsea.biomechanics.water import add_water_force
from subsea.fish.species import load_species, muscular_names

BEATS = 60
PRECISION = {"semi-implicit": 0.001, "explicit": 0.0001}  # tu
REPEATS = 200


@njit(cache=True, error_model="numpy")
def advance_explicitly(
    x: Floats,
    v: Floats,
    material: Material,
    muscles: Floats,
    water: Floats,
    force: Floats,
    step: float,
    watch: Floats,
) -> None:
    """Forward Euler with the same forces; arguments as for `solver.advance`."""
    band = np.empty((ROWS, HALF_BANDWIDTH + 1))
    load = np.zeros((ROWS, 3))
    for n in range(muscles.shape[0]):
        load[:NODES] = force
        add_water_force(x, v, water, material.drag, load)
        assemble(x, v, material, muscles[n], step, band, load, watch[:2])
        watch[2] = 1.0
        for i in range(NODES):
            for axis in range(3):
                x[i, axis] += step * v[i, axis]
                v[i, axis] = load[i, axis] * step / material.mass[i]


def survives(advance: Callable[..., None], body: Body, beat: Floats, step: float) -> bool:
    """True if the body keeps its shape through BEATS of fast swimming in steps of `step` tu."""
    duration = len(beat) * STEP
    times = np.arange(int(duration / step)) * step
    contraction = beat[(times / STEP).astype(int) % len(beat)]
    state, none = at_rest(body), np.zeros((NODES, 3))
    for number in range(BEATS):
        muscles = muscle_lengths(body, min(1.0, (number + 1) / 4) * contraction)
        advance(state.x, state.v, body.material, muscles, STILL, none, step, state.watch)
        if not is_sound(state):
            return False
    return True


def longest_step(name: str, advance: Callable[..., None], body: Body, beat: Floats) -> float:
    """The longest step in tu that every shorter one in the list survives too."""
    precision = PRECISION[name]
    count = 1
    while survives(advance, body, beat, (count + 1) * precision) and count * precision < 0.2:
        count += 1
    return count * precision


def costs(body: Body, state: BodyState) -> dict[str, float]:
    """Microseconds of a step, and of the same system by LAPACK."""
    band, load = np.zeros((ROWS, HALF_BANDWIDTH + 1)), np.zeros((ROWS, 3))
    strain, muscle = np.array([np.inf, 0.0]), body.length[:MUSCLES].copy()
    add_water_force(state.x, state.v, STILL, body.drag, load)
    assemble(state.x, state.v, body.material, muscle, STEP, band, load, strain)  # fmt: skip
    lower = np.ascontiguousarray(band[:NODES].T)
    right = load[:NODES].copy()
    ours, mine = band.copy(), load.copy()
    factorize(ours)
    substitute(ours, mine)
    np.testing.assert_allclose(
        solveh_banded(lower, right, lower=True), mine[:NODES], rtol=1e-8, atol=1e-12
    )
    return {
        "one whole step, compiled": step_cost(body, state),
        "scipy.linalg.solveh_banded, three right-hand sides": fastest_us(
            lambda: solveh_banded(lower, right, lower=True, check_finite=False), REPEATS
        ),
    }


def main() -> None:
    """Print a table."""
    for name in sys.argv[1:] or muscular_names():
        muscles = load_species(name).muscles
        if muscles is None:
            continue
        body = build_body(muscles.body)
        beat = beat_contraction(muscles.swim, 1.0)
        swimming = steady_beat(body, beat).state
        print(name)
        times = costs(body, swimming)
        for what, duration in times.items():
            print(f"  {what:52s}{duration:9.2f} µs")
        step, banded = times.values()
        print(f"  {'the step over the solve':52s}{step / banded:9.2f} ×")
        implicit = longest_step("semi-implicit", advance, body, beat)
        explicit = longest_step("explicit", advance_explicitly, body, beat)
        print(f"  {'longest sound step, semi-implicit':52s}{implicit:9.3f} tu")
        print(f"  {'longest sound step, explicit Euler':52s}{explicit:9.4f} tu")
        print(f"  {'gain':52s}{implicit / explicit:9.0f} ×")


if __name__ == "__main__":
    main()
