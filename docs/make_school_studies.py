"""Plot the studies of how-to/study-schools.md: `python docs/make_school_studies.py [FOLDER]`.

Sweeps `docs/studies` into `docs/studies/runs`, where finished runs are kept, and draws three
pictures. Few and short runs: raise SEEDS and seconds below for figures to rely on.
"""

import csv
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

from subsea.base.system import cores
from subsea.jobs.workers import process_pool
from subsea.kernels import kernel
from subsea.lab.sweep import Sweep, sweep
from subsea.world.world import TICK_S

mpl.use("agg")
from matplotlib import pyplot as plt

HERE = Path(__file__).parent
STUDIES, RUNS = HERE / "studies", HERE / "studies" / "runs"
SCHOOL, STATES, HUNTER = (str(STUDIES / f"{name}.toml") for name in ("school", "states", "hunter"))
Row = dict[str, float]

SIZES, STATE_SEEDS, STATE_S = (30, 70, 150, 300), range(1, 4), 120.0
# Tunstrøm et al. (2013) draw densities of both measures; the trend is given as text.
TUNSTROM = {
    "polarised": "golden shiners: less with size",
    "milling": "golden shiners: more with size",
}

GROUPS, SHARES = (20, 50), (0.05, 0.1, 0.2, 0.4)
GOAL_SEEDS, GOAL_S, GOAL_DEG = range(1, 2), 25.0, 90.0
MODEL_SEEDS = range(1, 6)  # of the published model
LEADING = {"school.goal": 0.3}
ANGLES = (30, 60, 90, 120, 150)
TWO = {"school.goal": 0.9, "school.goal_feedback": 1.5}
PREY, HUNT_SEEDS, HUNT_S = (1, 6, 20), range(1, 17), 30.0
# Range of the captures per attack on 20 over those on single prey, of four predators (Neill and
# Cullen 1974), as assets/swimming.toml has it.
NEILL = 0.0, 0.8


def swept(
    name: str, scenario: str, seeds: Sequence[int], seconds: float, values: dict[str, Any]
) -> list[Row]:
    """The rows of a sweep."""
    choices = {key: one if isinstance(one, list) else [one] for key, one in values.items()}
    runs = Sweep(scenario, list(seeds), round(seconds / TICK_S), None, choices)
    sweep(runs, RUNS / name, pool=process_pool(cores()), csv=True)
    with (RUNS / name / "sweep.csv").open(encoding="utf-8", newline="") as file:
        return [_numbers(row) for row in csv.DictReader(file)]


def _numbers(row: dict[str, Any]) -> Row:
    found = {}
    for key, value in row.items():
        try:
            found[key] = math.nan if value in (None, "") else float(value)
        except ValueError:
            continue
    return found


def states() -> Any:
    """Draw polarised and milling shares over group sizes (Tunstrøm et al. 2013)."""
    rows = swept("states", STATES, STATE_SEEDS, STATE_S, {"fish.0.number": list(SIZES)})
    figure, axes = plt.subplots(1, 2, figsize=(7, 2.8), sharey=True)
    for axis, name in zip(axes, ("polarised", "milling"), strict=True):
        for row in rows:
            axis.plot(row["fish.0.number"], row[f"schools.{name}_share"], ".", color="0.7")
        mean = [_mean(rows, f"schools.{name}_share", "fish.0.number", n) for n in SIZES]
        axis.plot(SIZES, mean, "o-", label="subsea")
        axis.text(0.03, 0.93, TUNSTROM[name], transform=axis.transAxes, fontsize=8, va="top")
        axis.set(title=name, xlabel="fishes", ylim=(-0.05, 1.05), xscale="log", xticks=SIZES)
        axis.set_xticks(SIZES, [str(n) for n in SIZES])
        axis.minorticks_off()
        print(name, np.round(mean, 2))
    axes[0].set_ylabel("share of the time")
    axes[0].legend(frameon=False)
    return figure


def minority() -> Any:
    """Draw accuracy over the informed share, and the course between two goals (Couzin 2005)."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7, 2.8))
    for n in GROUPS:
        mean = []
        for share in SHARES:
            goals = f"[{{ share = {share}, heading_deg = {GOAL_DEG} }}]"
            rows = swept(f"minority-{n}-{share}", SCHOOL, GOAL_SEEDS, GOAL_S,
                         {**LEADING, "fish.0.number": n, "school.goals": [goals]})  # fmt: skip
            off = [row["schools.course_deg"] - GOAL_DEG for row in rows]
            mean.append(float(np.mean(np.cos(np.radians(off)))))
        left.plot(SHARES, mean, "o-", label=f"{n} fishes")
        model = [np.mean([np.cos(couzin(n, [(share, 0.0)], seed)) for seed in MODEL_SEEDS])
                 for share in SHARES]  # fmt: skip
        left.plot(SHARES, model, "--", lw=1, color=left.lines[-1].get_color())
        print(n, np.round(mean, 2), "model", np.round(model, 2))
    left.set(xlabel="share informed", ylabel="cosine of course to goal", ylim=(-1.05, 1.05))
    left.plot([], [], "k--", lw=1, label="Couzin's model")
    left.legend(frameon=False)
    for shares, marker in (((0.1, 0.1), "o"), ((0.16, 0.08), "s")):
        for angle in ANGLES:
            half = angle / 2
            goals = ", ".join(
                f"{{ share = {share}, heading_deg = {side * half} }}"
                for share, side in zip(shares, (1, -1), strict=True)
            )
            rows = swept(f"conflict-{shares[0]}-{angle}", SCHOOL, GOAL_SEEDS, GOAL_S,
                         {**TWO, "fish.0.number": 50, "school.goals": [f"[{goals}]"]})  # fmt: skip
            course = [row["schools.course_deg"] for row in rows]
            label = f"{shares[0]:.0%} and {shares[1]:.0%}" if angle == ANGLES[0] else None
            colour = "C0" if marker == "o" else "C1"
            right.plot([angle] * len(course), course, marker, color=colour, ms=4, label=label)
            print(shares, angle, np.round(course))
    model = [couzin(50, [(0.1, np.radians(angle / 2)), (0.1, -np.radians(angle / 2))], seed, True)
             for angle in ANGLES for seed in MODEL_SEEDS]  # fmt: skip
    angles = np.repeat(ANGLES, len(MODEL_SEEDS))
    right.plot(angles + 4, np.degrees(model), "kx", ms=4, label="the model, 10% and 10%")
    print("model", np.round(np.degrees(model)))
    for side in (1, -1):
        right.plot(ANGLES, [side * angle / 2 for angle in ANGLES], "k:", lw=1)
    right.axhline(0, color="0.7", lw=1)
    right.set(xlabel="angle between the goals, °", ylabel="course, °", ylim=(-100, 100))
    right.legend(frameon=False, fontsize=7, loc="lower left")
    return figure


NEAR, FAR, TURN, SPEED, STEP, BLUR, WEIGHT = 1.0, 6.0, 2.0, 1.0, 0.2, 0.01, 0.5
STEPS = 1200
ON_COURSE, GAIN, LOSS, MOST = math.radians(20.0), 0.012, 0.0008, 0.6


def couzin(
    n: int, goals: Sequence[tuple[float, float]], seed: int, feedback: bool = False
) -> float:
    """Course, rad, of n animals in the model of Couzin et al. (2005).

    `goals` are shares of the animals and directions. They turn from others within NEAR, else to
    those within FAR and their headings, and the informed also to their goal, with WEIGHT. With
    feedback the weight grows on course and shrinks off it.
    """
    rng = np.random.default_rng(seed)
    goal, weight, first = np.zeros((n, 2)), np.zeros(n), 0
    for share, direction in goals:
        those = slice(first, first + max(round(share * n), 1))
        goal[those], weight[those] = (math.cos(direction), math.sin(direction)), WEIGHT
        first = those.stop
    place = rng.uniform(0, math.sqrt(n), (n, 2))
    heading = rng.uniform(-math.pi, math.pi, n)
    return float(_course(place, heading, goal, weight, rng.normal(0, BLUR, (STEPS, n)), feedback))


@kernel
def _course(place: Any, heading: Any, goal: Any, weight: Any, blur: Any, feedback: bool) -> float:
    """Move the animals, in place, and return the course of the second half."""
    n = len(place)
    start = np.zeros(2)
    for step in range(len(blur)):
        if step == len(blur) // 2:
            start[0], start[1] = place[:, 0].mean(), place[:, 1].mean()
        turned = heading.copy()
        for i in range(n):
            ahead = np.array([math.cos(heading[i]), math.sin(heading[i])])
            apart, wish, close = np.zeros(2), ahead.copy(), False
            for j in range(n):
                way = place[j] - place[i]
                gap = math.sqrt(way[0] * way[0] + way[1] * way[1])
                if j == i or gap >= FAR:
                    continue
                way /= max(gap, 1e-9)
                if gap < NEAR:
                    apart -= way
                    close = True
                wish[0] += way[0] + math.cos(heading[j])
                wish[1] += way[1] + math.sin(heading[j])
            wish /= max(math.sqrt(wish[0] * wish[0] + wish[1] * wish[1]), 1e-9)
            if feedback and weight[i] > 0.0:
                cosine = ahead[0] * goal[i, 0] + ahead[1] * goal[i, 1]
                if cosine > math.cos(ON_COURSE):
                    weight[i] = min(weight[i] + GAIN, MOST)
                else:
                    weight[i] = max(weight[i] - LOSS, 1e-9)
            wish += weight[i] * goal[i]
            if close:
                wish = apart
            off = math.atan2(wish[1], wish[0]) + blur[step, i] - heading[i]
            off = (off + math.pi) % (2 * math.pi) - math.pi
            turned[i] += min(max(off, -TURN * STEP), TURN * STEP)
        heading[:] = turned
        for i in range(n):
            place[i, 0] += SPEED * STEP * math.cos(heading[i])
            place[i, 1] += SPEED * STEP * math.sin(heading[i])
    return math.atan2(place[:, 1].mean() - start[1], place[:, 0].mean() - start[0])


def confusion() -> Any:
    """Draw the success of attacks over the size of the group (Neill and Cullen 1974)."""
    rows = swept("confusion", HUNTER, HUNT_SEEDS, HUNT_S, {"fish.1.number": list(PREY)})
    risk = []
    for n in PREY:
        those = [row for row in rows if row["fish.1.number"] == n]
        attacks = sum(row["captures.attacks"] for row in those)
        caught = sum(row["captures.successful_attacks"] for row in those)
        risk.append(caught / max(attacks, 1))
        print(n, f"{caught:.0f} of {attacks:.0f} attacks")
    figure, axis = plt.subplots(figsize=(3.6, 2.8))
    axis.plot(PREY, np.divide(risk, max(risk[0], 1e-9)), "o-", label="subsea")
    axis.plot([PREY[-1]] * 2, NEILL, lw=6, alpha=0.3, color="k", label="four predators")
    axis.set(xlabel="prey in the group", ylabel="captures per attack,\nover those of one")
    axis.set_xticks(PREY)
    axis.legend(frameon=False)
    return figure


def _mean(rows: Sequence[Row], measure: str, key: str, value: float) -> float:
    return float(np.nanmean([row[measure] for row in rows if row[key] == value]))


STUDIES_DRAWN: dict[str, Callable[[], Any]] = {
    "schools-confusion": confusion, "schools-states": states, "schools-minority": minority,
}  # fmt: skip


def main() -> None:
    """Write `NAME.png` into the folder."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else HERE / "pictures")
    for name, draw in STUDIES_DRAWN.items():
        figure = draw()
        figure.tight_layout()
        figure.savefig(folder / f"{name}.png", dpi=100)


if __name__ == "__main__":
    main()
