"""Repeat the experiments of KS on learning to swim: `python docs/learn_like_ks.py [FOLDER]`.

Each uses a fusilier in Tu's water and fixed seeds: (a) one frequency for all muscles against one
for each, (b) turns by sinusoids against the steering map, (c) folding bodies, (d) roll caused by a
coarse triangulation. Prints the numbers of docs/developers/learning-figures.md and draws
FOLDER/ks_*.png (default docs/pictures). `--quick` runs all parts briefly, for the tests.
"""

import argparse
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numba import njit
from tqdm import tqdm

from capture.inspection.gait import entries, muscle_work, speed_kept
from capture.learning.search import one_by_one, search
from capture.learning.turn import with_holds
from subsea.biomechanics import simulation, solver, water
from subsea.biomechanics.body import (
    MUSCLES,
    TRIANGLE_WEIGHTS,
    TRIANGLES,
    Body,
    Floats,
    body_frame,
    build_body,
)
from subsea.biomechanics.body_plan import Muscles, SwimPlan, TurnPlan
from subsea.biomechanics.controllers import ease, swim_contraction, turn_contraction
from subsea.biomechanics.fins import headings
from subsea.biomechanics.simulation import BodyState, at_rest, copy_state, is_sound, simulate
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK
from subsea.biomechanics.trial import beat_contraction, beat_phase, steady_beat
from subsea.fish.species import load_species

SIDES = 6  # muscle groups as in KS's flat fish: upper and lower together, left and right separate
# The group of each of the twelve muscles: segment by segment, left before right.
OF_SIDE = np.array([2 * (k // 4) + (k % 4 in (1, 2)) for k in range(MUSCLES)])
FREQUENCIES = (0.1, 0.4)  # beats a tu; the shipped gait has 0.216
STRONGEST = 0.5  # greatest contraction searched
ANGLE = 60.0  # degrees of the turns compared
RISE_TU = 5.0
ROLL_TU = 400.0
START_BEATS = 8  # until a start from rest has found its heading


class Effort(NamedTuple):
    """Sizes of the experiments."""

    seeds: int = 12
    budget: int = 500
    swim_tu: float = 120.0
    turn_seeds: int = 5
    turn_budget: int = 400
    folds: int = 120
    roll_tu: float = ROLL_TU


QUICK = Effort(seeds=2, budget=6, swim_tu=20.0, turn_seeds=1, turn_budget=6, folds=6, roll_tu=60.0)


class Sinusoids(NamedTuple):
    """A rest length is shortened by amplitude (1 + sin(2π frequency t + phase))/2 (KS §I.D)."""

    amplitude: Floats  # (6,)
    frequency: Floats  # (6,) a tu
    phase: Floats  # (6,) radians


def sinusoids(point: Floats, one_frequency: bool) -> Sinusoids:
    """The controller at a point of the unit box: amplitudes, phases, then one frequency or six."""
    low, high = FREQUENCIES
    frequency = low + point[2 * SIDES :] * (high - low)
    return Sinusoids(
        STRONGEST * point[:SIDES],
        np.full(SIDES, frequency[0]) if one_frequency else frequency,
        2 * np.pi * point[SIDES : 2 * SIDES],
    )


def contraction_of(controller: Sinusoids, steps: int, about_rest: bool = False) -> Floats:
    """Contractions (steps, 12) of the twelve muscles, faded in at the start.

    ``about_rest`` lets rest lengths swing symmetrically about the natural ones.
    """
    time = STEP * np.arange(steps)[:, None]
    wave = np.sin(2 * np.pi * controller.frequency * time + controller.phase)
    share = wave if about_rest else (1 + wave) / 2
    sides = ease(time / RISE_TU) * controller.amplitude * share
    return np.asarray(sides[:, OF_SIDE])


def whole_ticks(tu: float) -> int:
    """Number of steps of whole ticks in about this time."""
    return round(tu / STEP / STEPS_PER_TICK) * STEPS_PER_TICK


# (a) One frequency, or one for each muscle


def forward_speed(body: Body, controller: Sinusoids, tu: float) -> float:
    """Mean speed from rest, L/tu; negative if the body loses its shape, the sooner the lower."""
    state = at_rest(body)
    start = state.x.mean(axis=0)
    contraction = contraction_of(controller, whole_ticks(tu))
    parts = np.array_split(contraction.reshape(-1, STEPS_PER_TICK, MUSCLES), 8)
    for done, part in enumerate(parts):
        simulate(body, state, part.reshape(-1, MUSCLES))
        if not is_sound(state):
            return -0.1 * (1 - done / len(parts))
    # At rest the fish heads along x.
    return float((state.x.mean(axis=0) - start)[0] / np.ptp(body.rest[:, 0]) / tu)


def frequencies(body: Body, effort: Effort, folder: Path) -> None:
    """Compare the results of equal budgets."""
    curves: dict[str, Floats] = {}
    for method in ("annealing", "cma"):
        for one in (True, False):
            name = f"{method}, {'one frequency' if one else 'six frequencies'}"
            runs = []
            for seed in tqdm(range(1, effort.seeds + 1), desc=f"(a) {name}", disable=None):
                speeds: list[float] = []
                dimensions = 2 * SIDES + (1 if one else SIDES)
                search(
                    one_by_one(
                        lambda point, one=one: (
                            -forward_speed(body, sinusoids(point, one), effort.swim_tu)
                        )
                    ),
                    np.random.default_rng(seed).random(dimensions),
                    method,
                    effort.budget,
                    seed,
                    lambda tried, speeds=speeds: speeds.append(-tried.loss),
                )
                runs.append(np.maximum.accumulate(speeds))
            curves[name] = np.array(runs)
    print("(a) best speed, L/tu:                 median   quartiles        best")
    for name, runs in curves.items():
        low, middle, high = np.quantile(runs[:, -1], (0.25, 0.5, 0.75))
        print(f"    {name:<30} {middle:8.4f}   {low:.4f}-{high:.4f}  {runs[:, -1].max():8.4f}")
    picture = Figure(figsize=(10, 3.6))
    left, right = picture.subplots(1, 2, sharey=True)
    for (name, runs), colour in zip(curves.items(), ("C0", "C3", "0.4", "0.75"), strict=True):
        low, middle, high = np.quantile(runs, (0.25, 0.5, 0.75), axis=0)
        tries = np.arange(1, runs.shape[1] + 1)
        left.plot(tries, middle, color=colour, label=name)
        left.fill_between(tries, low, high, color=colour, alpha=0.15)
    left.set_ylim(0, None)
    left.set_xlabel("tries")
    left.set_ylabel("best speed so far, L/tu")
    left.legend(fontsize=7)
    right.boxplot([runs[:, -1] for runs in curves.values()])
    right.set_xticks(range(1, len(curves) + 1), [n.replace(", ", "\n") for n in curves], fontsize=7)
    right.set_title(f"after {effort.budget} tries, {effort.seeds} seeds", fontsize=9)
    save(picture, folder / "ks_frequencies.png")


# (b) Turning


class Turn(NamedTuple):
    """The headings and frames of a turn."""

    heading: Floats  # degrees, in each tick of a beat before, the turn and six beats after
    frames: Floats  # of the turn alone

    def by(self, beat: int) -> float:
        """Degrees between the mean headings of the first and last ``beat`` ticks."""
        return float(self.heading[-beat:].mean() - self.heading[:beat].mean())


def turn_from(
    body: Body, swim: SwimPlan, start: BodyState, phase: float, contraction: Floats
) -> Turn:
    """Follow ``contraction`` from steady swimming at grade medium, then swim for six beats."""
    state = copy_state(start)
    beat = swim_contraction(swim, phase + beat_phase(swim, swim.ticks_per_beat), swim.medium)
    # The headings of a steady beat equal those of the beat before.
    before = simulate(body, copy_state(state), beat)
    turning = simulate(body, state, contraction)
    after = simulate(body, state, np.tile(beat, (6, 1)))
    heading = headings(np.concatenate([before, turning, after]))
    return Turn(heading if is_sound(state) else np.full_like(heading, np.nan), turning)


def thrash(heading: Floats) -> float:
    """Total variation of a heading beyond its net change, degrees."""
    return float(np.abs(np.diff(heading)).sum() - abs(heading[-1] - heading[0]))


def turning(body: Body, swim: SwimPlan, turn: TurnPlan, effort: Effort, folder: Path) -> None:
    """Compare turns by annealed sinusoids with those of the steering map."""
    steady = steady_beat(body, beat_contraction(swim, swim.medium)).state
    starts = entries(body, swim, steady)
    beat, steps = swim.ticks_per_beat, len(turn_contraction(swim, turn, ANGLE))

    def sinusoidal(point: Floats | tuple[float, ...], about_rest: bool) -> Floats:
        return contraction_of(sinusoids(np.asarray(point), True), steps, about_rest)

    def loss(point: Floats, about_rest: bool) -> float:
        turned = turn_from(body, swim, steady, 0.0, sinusoidal(point, about_rest)).by(beat)
        return 360.0 if np.isnan(turned) else abs(turned - ANGLE)

    # Muscle lengths when the turn begins at a phase of the beat, which sinusoids do not have.
    muscles: dict[str, Callable[[float], Floats]] = {
        "steering map": lambda phase: turn_contraction(swim, turn, ANGLE, phase),
        "straight on": lambda phase: swim_contraction(
            swim, phase + 2 * np.pi * np.arange(steps) / (beat * STEPS_PER_TICK), swim.medium
        ),
    }
    families = {"contracting": False, "about rest": True}
    for family, swing in families.items():
        for seed in tqdm(range(1, effort.turn_seeds + 1), desc=f"(b) {family}", disable=None):
            best = search(
                one_by_one(lambda point, swing=swing: loss(point, swing)),
                np.random.default_rng(seed).random(2 * SIDES + 1),
                "annealing",
                effort.turn_budget,
                seed,
            )[0]
            muscles[f"{family}, {seed}"] = lambda phase, best=best, swing=swing: sinusoidal(
                best.point, swing
            )
    print("(b)                     turned °  worst phase  overshoot  to and fro  °/tu  kept  mJ/kg")
    picture = Figure(figsize=(10, 3.6))
    axes = picture.subplots(1, 2, sharey=True)
    tick = STEP * STEPS_PER_TICK
    for name, contraction in muscles.items():
        found = [turn_from(body, swim, *start, contraction(start[1])) for start in starts]
        angles = [one.by(beat) for one in found]
        first = found[0]
        during = first.heading[beat - 1 : beat + len(first.frames)]
        off = max((angle - angles[0] for angle in angles), key=abs)
        overshoot = during.max() - first.heading[-beat:].max()
        fastest, kept = np.abs(np.diff(during)).max() / tick, speed_kept(body, first.frames)
        # g cm²/tu² for each g is 0.01 J/kg.
        work = 10 * muscle_work(body, copy_state(steady), contraction(0.0)) / body.mass.sum()
        print(
            f"    {name:<20} {angles[0]:7.1f}  {off:+11.1f}  {overshoot:9.1f}"
            f"  {thrash(during):10.1f}  {fastest:4.1f}  {kept:4.2f}  {work:5.1f}"
        )
        style: dict[str, Any] = {"linewidth": 0.8}
        if name == "steering map":
            style = {"color": "k", "linewidth": 2}
        time = tick * (np.arange(len(first.heading)) - beat)
        for axis, family in zip(axes, families, strict=True):
            if family in name or "," not in name:
                axis.plot(time, first.heading - first.heading[:beat].mean(), label=name, **style)
    for axis, family in zip(axes, families, strict=True):
        axis.set_title(f"sinusoids {family}", fontsize=9)
        axis.set_xlabel("tu")
        axis.axvspan(0, steps * STEP, color="0.93")
        axis.legend(fontsize=6)
    axes[0].set_ylabel("heading, °")
    save(picture, folder / "ks_turning.png")


# (c) Folding


def folding(body: Body, effort: Effort, folder: Path) -> dict[float, float]:
    """Measure the fraction of random sinusoids that fold the body, by amplitude."""
    rng = np.random.default_rng(7)
    levels = np.round(np.arange(0.05, 0.61, 0.05), 2)
    shares = {}
    for level in tqdm(levels, desc="(c) folding", disable=None):
        folded = 0
        for _ in range(effort.folds):
            controller = Sinusoids(
                np.full(SIDES, level),
                np.full(SIDES, rng.uniform(*FREQUENCIES)),
                rng.uniform(0, 2 * np.pi, SIDES),
            )
            state = at_rest(body)
            simulate(body, state, contraction_of(controller, whole_ticks(60.0)))
            folded += not is_sound(state)
        shares[float(level)] = folded / effort.folds
    print("(c) amplitude: share folded  " + ", ".join(f"{a:g}: {s:.0%}" for a, s in shares.items()))
    picture = Figure(figsize=(6, 3.2))
    axis = picture.subplots()
    axis.plot([*shares], [*shares.values()], "o-")
    axis.set_xlabel("amplitude, share of rest length")
    axis.set_ylabel(f"folded, of {effort.folds} at random")
    save(picture, folder / "ks_folding.png")
    return shares


# (d) Rolling


def one_diagonal() -> tuple[Any, Floats]:
    """The hull with one diagonal in each quadrilateral face, as in KS."""
    halves = np.flatnonzero(TRIANGLE_WEIGHTS == 0.5)
    # Four triangles a face: two of the one diagonal, then two of the other.
    kept = np.sort([*np.flatnonzero(TRIANGLE_WEIGHTS == 1.0), *halves[halves_of(len(halves))]])
    return TRIANGLES[kept], np.ones(len(kept))


def halves_of(count: int) -> Any:
    """Which triangles of divided faces belong to the first diagonal."""
    return np.flatnonzero(np.arange(count) % 4 < 2)


def simulate_with(triangles: Any, weights: Floats) -> Callable[..., Floats]:
    """A `simulate` with another triangulation of the hull.

    The hull is a constant of the kernels, so they are compiled again.
    """

    def again(function: Any, **constants: Any) -> Any:
        # Under a name of its own: kernels of one name are one to the linker.
        name = f"{function.__name__}_{len(triangles)}_triangles"
        code = function.__code__.replace(co_name=name, co_qualname=name)
        return types.FunctionType(code, {**function.__globals__, **constants}, name)

    compile_ = njit(error_model="numpy")
    force = compile_(
        again(water.add_water_force.py_func, TRIANGLES=triangles, TRIANGLE_WEIGHTS=weights)
    )
    steps = compile_(again(solver.advance_solver.py_func, add_water_force=force))
    chain = compile_(again(solver.advance_chain.py_func, advance_solver=steps))
    step = compile_(again(solver.advance.py_func, advance_chain=chain))
    frames = compile_(again(simulation.advance_frames.py_func, advance=step))
    with_defaults = again(simulation.simulate, advance_frames=frames)
    with_defaults.__defaults__ = simulation.simulate.__defaults__
    return with_defaults  # type: ignore[no-any-return]


def roll_of(run: Callable[..., Floats], body: Body, swim: SwimPlan, tu: float) -> Floats:
    """Roll, pitch and heading (beats, 3), degrees, of each beat of fast swimming from rest."""
    state = at_rest(body)
    beat = beat_contraction(swim, 1.0)
    found = []
    for _ in range(round(tu / STEP / len(beat))):
        frames = run(body, state, beat)
        rotation = body_frame(frames)[1]
        forward, side = rotation[:, :, 0].mean(axis=0), rotation[:, :, 2].mean(axis=0)
        up = rotation[:, :, 1].mean(axis=0)
        found.append(
            (np.arctan2(side[1], up[1]), np.arcsin(forward[1]), np.arctan2(-forward[2], forward[0]))
        )
    return np.degrees(np.unwrap(np.array(found), axis=0))


def muscles_of(name: str) -> Muscles:
    """The body and the gait that a species had in Tu's water."""
    muscles = load_species(str(Path(__file__).with_name(f"tu_{name}.toml"))).muscles
    assert muscles
    return muscles


def rolling(effort: Effort, folder: Path) -> dict[str, Floats]:
    """Compare the attitude with one diagonal of each face and with both."""
    hulls = {"one diagonal": simulate_with(*one_diagonal()), "both diagonals": simulate}
    found = {}
    picture = Figure(figsize=(6, 3.2))
    axis = picture.subplots()
    print(f"(d) after {effort.roll_tu:g} tu of fast swimming     roll °   pitch °  heading °")
    for name in ("fusilier", "emperor_angelfish"):
        muscles = muscles_of(name)
        body = build_body(muscles.body)
        for hull, run in hulls.items():
            angles = roll_of(run, body, muscles.swim, effort.roll_tu)
            found[f"{name}, {hull}"] = angles
            roll, pitch, heading = angles[-1] - angles[min(START_BEATS, len(angles) - 1)]
            print(f"    {name + ', ' + hull:<34} {roll:+8.3f}  {pitch:+8.3f}  {heading:+8.3f}")
            time = np.linspace(0, effort.roll_tu, len(angles))
            axis.plot(time, angles[:, 0], label=f"{name.replace('_', ' ')}, {hull}")
    axis.set_xlabel("tu")
    axis.set_ylabel("roll, °")
    axis.legend(fontsize=7)
    save(picture, folder / "ks_rolling.png")
    return found


def save(picture: Figure, path: Path) -> None:
    """Write a picture."""
    picture.savefig(path, dpi=80, bbox_inches="tight", metadata={"Software": None})


def main(arguments: list[str] | None = None) -> None:
    """Run the experiments."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parent / "pictures")
    parser.add_argument("--quick", action="store_true", help="spend little")
    parser.add_argument("--only", choices="abcd", default="abcd", help="one experiment")
    parser.add_argument("--seeds", type=int, help="of (a)")
    parser.add_argument("--tries", type=int, help="of each search of (a)")
    options = parser.parse_args(arguments)
    effort = QUICK if options.quick else Effort()
    given = {"seeds": options.seeds, "budget": options.tries}
    effort = effort._replace(**{key: number for key, number in given.items() if number})
    muscles = muscles_of("fusilier")
    plan, swim, turn = muscles
    body = build_body(plan)
    if "a" in options.only:
        frequencies(body, effort, options.folder)
    if "b" in options.only:
        steady = steady_beat(body, beat_contraction(swim, swim.medium)).state
        turning(body, swim, with_holds(body, swim, turn, steady), effort, options.folder)
    if "c" in options.only:
        folding(body, effort, options.folder)
    if "d" in options.only:
        rolling(effort, options.folder)


if __name__ == "__main__":
    main()
