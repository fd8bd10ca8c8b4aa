"""Repeat the experiments of KS with a flat fish: the numbers of each, and its plot.

`docs/developers/two-dimensional-fish-figures.md` shows the results.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from capture.flat.controllers import (
    FRAME,
    FRAME_TU,
    LARGEST,
    RISE_TU,
    STEP_TU,
    TRY_TU,
    WAYS,
    Sinusoids,
    controller_at,
    gained,
    lengths,
    passage,
    run,
    steps_of,
    swim_by,
)
from capture.flat.drawing import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PINK,
    YELLOW,
    Skin,
    bare,
    draw_fish,
    draw_scaffold,
)  # fmt: skip
from capture.flat.lessons import HOT_L, FlatLearner, best_first
from capture.flat.physics import (
    add_forces,
    energy,
    explicit_limit,
    heading,
    is_sound,
    middle,
    modes,
    room,
    swim,
)  # fmt: skip
from capture.flat.scaffold import FlatBody
from subsea.biomechanics.body import Floats


class Result(NamedTuple):
    """The lines to print, and a function that draws on an empty matplotlib figure."""

    lines: list[str]
    draw: Callable[[Any], None]


def show_body(learner: FlatLearner) -> Result:
    """Draw the scaffold at rest, and the forces of water when they push the most ahead."""
    body = learner.body
    frames = swim_by(body, learner.swimmer)
    limp = body._replace(stiffness=0.0 * body.stiffness, viscosity=0.0 * body.viscosity)
    angle = heading(body, frames[:, 0])
    pushes = []
    for (x, v), direction in zip(frames, angle, strict=True):
        force = np.zeros_like(x)
        add_forces(x, v, limp, body.length, force)
        pushes.append(force.sum(axis=0) @ [np.cos(direction), np.sin(direction)])
    late = len(frames) // 2
    k = late + int(np.argmax(pushes[late:]))
    back = rotation(angle[k])
    x = (frames[k, 0] - middle(body, frames[k, 0])) @ back + middle(body, body.rest)
    along = np.diff(x[body.hull], axis=1)[:, 0]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    speed = (frames[k, 1] @ back)[body.hull].mean(axis=1)
    outward = np.maximum(0.0, (normal * speed).sum(axis=1) / np.linalg.norm(along, axis=1))
    force = -body.drag * (body.height * outward)[:, None] * normal
    greatest = np.linalg.norm(force, axis=1).max()

    def draw(page: Any) -> None:
        page.set_size_inches(7.4, 4.4)
        skin, (top, below) = Skin(body), page.subplots(2, 1)
        for axis, shape in ((top, body.rest), (below, x)):
            draw_fish(axis, skin, shape)
            draw_scaffold(axis, body, shape)
            axis.set(aspect="equal", xlim=(-1.08, 0.06), ylim=(-0.2, 0.2), ylabel="to the left, L")
        top.scatter(*(body.rest / body.long).T, s=3.0 * body.mass, color=BLACK, zorder=3)
        top.set_title("at rest: muscles in orange, the area of a dot is its mass", loc="left")
        ends = x[body.hull].mean(axis=1) / body.long
        for place, arrow in zip(ends, 0.16 * force / greatest, strict=True):
            if np.hypot(*arrow) > 0.01:
                style = {"arrowstyle": "-|>", "color": GREEN, "shrinkA": 0, "shrinkB": 0}
                below.annotate("", place, place - arrow, arrowprops=style)
        title = f"as it swims: the water's force, at most {greatest:.0f} g cm/tu² on an edge"
        below.set_title(title, loc="left")
        below.set_xlabel("along the body at rest, L; the nose is at 0")

    many = f"{len(body.mass)} points of {body.mass.sum():.0f} g, {len(body.units)} edges"
    return Result([f"{many}, {len(body.mirror)} muscles, {body.long:g} cm"], draw)


def rotation(angle: float) -> Floats:
    """Build the matrix (2, 2) that turns rows of points to the right by an angle, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


STEPS = {  # of the comparison: the step over explicit Euler's limit, implicit or not, colour
    "explicit, 0.9 of the limit": (0.9, False, GREEN),
    "explicit, 1.2 times": (1.2, False, PINK),
    "explicit, 2 times": (2.0, False, YELLOW),
    "explicit, 19 times": (19.0, False, ORANGE),
    "implicit, 19 times": (19.0, True, BLUE),
}
SWUM_STEPS = (0.0005, 0.002, 0.01, STEP_TU, 0.11, 0.22)  # tu


def released(body: FlatBody, tu: float) -> dict[str, tuple[Any, Floats]]:
    """List times, tu, and relative energies of a released, stretched fish, by step size."""
    limit, natural = explicit_limit(body), body.length[None, : len(body.mirror)]
    shown = {}
    for name, (share, implicit, _) in STEPS.items():
        step = share * limit
        muscles = np.repeat(natural, round(tu / step), axis=0)
        frames = swim(body._replace(drag=0.0), body.at_rest(1.05), muscles, step, implicit, 1)
        left = energy(body, frames)
        shown[name] = (np.asarray(step * np.arange(len(left))), left / left[0])
    return shown


def show_integrators(learner: FlatLearner) -> Result:
    """Compare explicit and implicit Euler: energies, stability, and the fish of KS's movie 1."""
    body, swimmer = learner.body, learner.swimmer
    both = explosion(learner)
    fold = int(np.argmax(room(body, both[0][:, 0]) <= 0))
    lines = [
        f"explicit Euler is stable to a step of {explicit_limit(body):.5f} tu, "
        f"here {STEP_TU} tu are taken",
        f"movie 1: explicit Euler folds the fish after {fold} steps of {STEP_TU} tu",
        "a step of            explicit  implicit: body lengths swum in 60 tu",
    ]
    for step in SWUM_STEPS:
        steps = round(TRY_TU / step)
        muscles = lengths(body, swimmer, steps, step=step)
        ends = [
            swim(body, body.at_rest(), muscles, step, implicit, steps)[-1, 0]
            for implicit in (False, True)
        ]
        far = [(middle(body, x) - middle(body, body.rest))[0] / body.long for x in ends]
        lines.append(f"    {step:8.4f} tu     {far[0]:8.3f}  {far[1]:8.3f}")
    energies, values = released(body, 60.0), STEP_TU * modes(body)

    def draw(page: Any) -> None:
        page.set_size_inches(7.4, 5.4)
        above, below = page.subfigures(2, 1, height_ratios=(1.9, 1.0))
        left, right = above.subplots(1, 2, width_ratios=(1.25, 1.0))
        for name, (time, shown) in energies.items():
            left.semilogy(time, shown, color=STEPS[name][2], label=name, linewidth=1.2)
        left.set(ylim=(1e-6, 1e8), xlabel="time, tu", ylabel="energy over that at first",
                 title="a stretched fish in a vacuum is let go")  # fmt: skip
        left.legend(loc="center right", bbox_to_anchor=(1.0, 0.72))
        around = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 200))
        right.fill(around.real - 1, around.imag, color=GREEN, alpha=0.2)
        right.text(-1, 0, "explicit\nis stable\nhere", ha="center", va="center", color=GREEN)
        right.plot(around.real + 1, around.imag, color=BLUE)
        right.text(1, 0, "implicit\nis stable\noutside", ha="center", va="center", color=BLUE)
        right.plot(values.real, values.imag, ".", color=ORANGE, label="of the fish, h = 0.055 tu")
        right.set(aspect="equal", xlim=(-2.1, 2.1), ylim=(-1.5, 1.75), xlabel="Re hλ",
                  ylabel="Im hλ", title="where a step may lie")  # fmt: skip
        right.legend(loc="upper center")
        steps = [0, *range(fold - 4, fold + 13, 4)]
        for row, name, frames in zip(
            below.subplots(2, len(steps)), ("explicit", "implicit"), both, strict=True
        ):
            row[0].set_ylabel(name)
            for axis, k in zip(row, steps, strict=True):
                if np.isfinite(frames[k]).all():
                    draw_scaffold(axis, body, frames[k, 0], 0.6)
                bare(axis, (-1.25, 0.25), (-0.3, 0.3))
                if row[0].get_ylabel() == "explicit":
                    axis.set_title(f"step {k}", fontsize=9)

    return Result(lines, draw)


def explosion(learner: FlatLearner) -> list[Floats]:
    """Swim with explicit and with implicit Euler, each step stored (KS movie 1)."""
    muscles = lengths(learner.body, learner.swimmer, 200)
    return [
        swim(learner.body, learner.body.at_rest(), muscles, STEP_TU, implicit, 1)
        for implicit in (False, True)
    ]


def show_learning(learner: FlatLearner) -> Result:
    """Plot an annealing, all seeds, and one frequency against one for each muscle."""
    families = {"one frequency": (learner.swims, BLUE), "many frequencies": (learner.many, ORANGE)}
    bests = {name: np.array([run.best for run in runs]) for name, (runs, _) in families.items()}
    lines = [
        f"{name}: median {np.median(best[:, -1]):.2f} L, "
        f"{best[:, -1].min():.2f} to {best[:, -1].max():.2f}"
        for name, best in bests.items()
    ]
    swimmer, mirror = learner.swimmer, learner.body.mirror
    left = np.flatnonzero(np.arange(len(mirror)) < mirror)
    against = np.degrees(swimmer.phase[left] - swimmer.phase[mirror[left]]) % 360
    lines.append(
        f"the best: {swimmer.frequency[0]:.3f} beats a tu, amplitudes "
        f"{np.round(swimmer.amplitude, 3)}, phases of left against right {np.round(against)}°"
    )

    def draw(page: Any) -> None:
        page.set_size_inches(7.4, 6.2)
        above, below = page.subfigures(2, 1)
        axis, first = above.subplots(), learner.swims[0]
        tries = np.arange(1, len(first.scores) + 1)
        axis.plot(tries, first.scores, ".", color=GREY, markersize=3, label="a try")
        axis.plot(tries, first.held, color=BLUE, linewidth=1.0, label="where it stands")
        axis.plot(tries, first.best, color=ORANGE, linewidth=1.8, label="best so far")
        axis.set(xlabel="tries", ylabel="way ahead in 60 tu, L", title="one annealing",
                 ylim=(-1.1, 1.08 * bests["one frequency"].max()))  # fmt: skip
        cold = axis.twinx()
        cooling = HOT_L * np.geomspace(1.0, 0.01, len(tries))
        cold.semilogy(tries, cooling, color=PINK, linestyle="--")
        cold.set_ylabel("temperature, L", color=PINK)
        cold.spines["right"].set_visible(True)
        axis.legend(loc="lower right", ncols=3)
        left, right = below.subplots(1, 2, sharey=True, width_ratios=(1.6, 1.0))
        for place, (name, best) in enumerate(bests.items()):
            colour, end = families[name][1], np.median(best[:, -1])
            left.plot(tries, best.T, color=colour, alpha=0.35, linewidth=0.9)
            left.plot(tries, np.median(best, axis=0), color=colour, linewidth=2.4, label=name)
            aside = place + np.random.default_rng(1).uniform(-0.12, 0.12, len(best))
            right.plot(aside, best[:, -1], "o", color=colour, alpha=0.7)
            right.hlines(end, place - 0.25, place + 0.25, color=colour, linewidth=2.4)
        left.set(xlabel="tries", ylabel="best way so far, L", ylim=(0, None),
                 title=f"{len(learner.swims)} seeds, and their median")  # fmt: skip
        left.legend(loc="upper left")
        right.set_xticks([0, 1], ["one", "many"])
        right.set(xlabel="frequencies", xlim=(-0.5, 1.5), title=f"after {len(tries)} tries")

    return Result(lines, draw)


def show_swims(learner: FlatLearner) -> Result:
    """Draw a fish before, during and after learning, and how far each part of it swings."""
    body, best = learner.body, best_first(learner.swims)
    winner = best[0]
    halfway = int(np.argmax(winner.best >= 0.5 * winner.best[-1]))
    points = {
        "before: the first try": winner.points[0],
        f"meanwhile: try {halfway + 1}": winner.points[halfway],
        f"after: the best of {len(winner.points)} tries": winner.winner,
    }
    swims = {name: swim_by(body, controller_at(body, point)) for name, point in points.items()}
    paths = {name: middle(body, frames[:, 0]) / body.long for name, frames in swims.items()}
    far = {name: path[-1, 0] - path[0, 0] for name, path in paths.items()}

    def draw(page: Any) -> None:
        page.set_size_inches(7.4, 6.6)
        above, below = page.subfigures(2, 1, height_ratios=(2.6, 1.4))
        skin, rows = Skin(body), above.subplots(3, 1, sharex=True)
        for axis, (name, frames) in zip(rows, swims.items(), strict=True):
            for k in np.linspace(0, len(frames) - 1, 5).astype(int):
                draw_fish(axis, skin, frames[k, 0], BLUE, 0.35 + 0.65 * k / (len(frames) - 1))
            axis.plot(*paths[name].T, color=ORANGE, linewidth=1.6)
            axis.set(aspect="equal", ylim=(-0.32, 0.32), yticks=[-0.2, 0.0, 0.2], ylabel="L")
            axis.set_title(f"{name}: {far[name]:+.2f} L in {TRY_TU:g} tu", loc="left")
        rows[-1].set_xlabel("ahead, L; a fish each 15 tu, and the way of its centre of mass")
        rows[-1].set_xlim(-1.15, 0.15 + winner.scores.max())
        left, right = below.subfigures(1, 2, width_ratios=(1.6, 1.0))
        beat, frames = 1.0 / learner.swimmer.frequency[0], [*swims.values()][-1]
        for k, axis in enumerate(left.subplots(1, 8)):
            x = frames[round((TRY_TU - beat + beat * k / 8) / STEP_TU / FRAME), 0]
            x = (x - middle(body, x)) @ np.array([[0.0, 1.0], [-1.0, 0.0]])  # ahead is up
            draw_fish(axis, skin, x)
            draw_scaffold(axis, body, x, 0.5)
            bare(axis, (-0.22, 0.22), (-0.75, 0.5))
            axis.set_title(f"{k}/8\nbeat", fontsize=8)
        axis = right.subplots()
        for number, tries in enumerate(best[:4]):
            place, sway = envelope(skin, controller_at(body, tries.winner))
            axis.plot(place, sway, color=GREEN, alpha=0.4 if number else 1.0)
        axis.set(xlabel="behind the nose, L", ylabel="farthest to a side, L", ylim=(0, None),
                 title="how far each part swings")  # fmt: skip

    return Result([f"{name}: {way:+.3f} L" for name, way in far.items()], draw)


def envelope(skin: Skin, controller: Sinusoids) -> tuple[Floats, Floats]:
    """Measure positions along the midline, L, and their amplitudes about the mean path, L."""
    body, beat = skin.body, 1.0 / controller.frequency[0]
    frames = swim_by(body, controller)[-round(2 * beat / FRAME_TU) :, 0]
    line, path = skin.midline(frames), middle(body, frames)
    way = (path[-1] - path[0]) / np.hypot(*(path[-1] - path[0]))
    # About the straight line that the centre follows in the mean.
    time = np.linspace(-0.5, 0.5, len(path))[:, None]
    mean = path.mean(axis=0) + time * (path[-1] - path[0])
    aside = (line - mean[:, None]) @ np.array([-way[1], way[0]])
    aside -= aside.mean(axis=0)
    return -skin.midline(body.rest)[:, 0] / body.long, np.abs(aside).max(axis=0) / body.long


def show_turns(learner: FlatLearner) -> Result:
    """Draw learned turns: headings, and the path of the best."""
    body, start = learner.body, learner.swum
    onward = lengths(body, learner.swimmer, steps_of(TRY_TU), TRY_TU)
    angle = np.degrees(heading(body, run(body, onward, start)[:, 0]))
    straight = angle - angle[0]
    thrash = np.abs(np.diff(angle)).sum() - abs(straight[-1])
    lines = [f"swimming on: {gained(angle):+.1f}°, to and fro {thrash:.0f}°"]
    lines.append("turns:       gained   fastest   to and fro   way")
    swims, turns = [], []
    for tries in best_first(learner.turns):
        frames = swim_by(body, controller_at(body, tries.winner), start)
        angle = np.degrees(heading(body, frames[:, 0]))
        swims.append(frames)
        turns.append(angle - angle[0])
        rate = np.abs(np.diff(turns[-1])).max() / FRAME_TU
        thrash = np.abs(np.diff(turns[-1])).sum() - abs(turns[-1][-1])
        way = np.hypot(*(middle(body, frames[-1, 0]) - middle(body, frames[0, 0]))) / body.long
        lines.append(
            f"    left  {gained(turns[-1]):+6.1f}°  {rate:5.1f}°/tu  {thrash:8.0f}°  {way:6.2f} L"
        )
    best = learner.turner
    amplitudes = np.round(best.amplitude, 3)
    lines.append(f"the best: {best.frequency[0]:.3f} beats a tu, amplitudes {amplitudes}")

    def draw(page: Any) -> None:
        page.set_size_inches(7.4, 3.6)
        skin, (left, right) = Skin(body), page.subplots(1, 2, width_ratios=(1.0, 1.15))
        time = FRAME_TU * np.arange(len(straight))
        left.plot(time, straight, color=GREY, linewidth=1.2, label="swims on")
        left.plot(time, turns[0], color=BLUE, linewidth=2.0, label="learned, the best")
        for angle in turns[1:]:
            left.plot(time, angle, color=BLUE, linewidth=1.0, alpha=0.4)
        left.set(xlabel="time, tu", ylabel="heading, ° to the left", title="headings")
        left.legend(loc="upper left")
        x = swims[0][:, 0] - middle(body, swims[0][0, 0])
        x = x @ rotation(heading(body, swims[0][:1, 0])[0])
        for k in np.linspace(0, len(x) - 1, 5).astype(int):
            draw_fish(right, skin, x[k], BLUE, 0.35 + 0.65 * k / len(x))
        right.plot(*(middle(body, x) / body.long).T, color=ORANGE, linewidth=1.6)
        right.set(aspect="equal", xlabel="ahead, L", ylabel="to the left, L",
                  title="the best, a fish each 15 tu")  # fmt: skip

    return Result(lines, draw)


GOALS_L = ((4.0, 4.0), (-3.5, -4.5))
LATE_TU = 200.0
PASSED = (0.06, 0.09, 0.12, 0.15, 0.18, 0.21)
COLOURS = dict(zip(WAYS, (ORANGE, GREEN, BLUE), strict=True))


def tightest(body: FlatBody, old: Sinusoids, new: Sinusoids, moments: Floats, way: str) -> Floats:
    """Measure the least room (m,) of the scaffold in transitions at several times, tu."""
    whole = run(body, lengths(body, old, steps_of(moments.max() + 1.0)))
    least = []
    for moment in moments:
        frame = round(moment / STEP_TU / FRAME)
        begin = frame * FRAME * STEP_TU
        first = passage(body, old, new, begin, way)
        after = lengths(body, new, steps_of(RISE_TU), begin + STEP_TU * len(first))
        tight = room(body, run(body, np.concatenate([first, after]), whole[frame])[:, 0])
        least.append(tight.min() if np.isfinite(tight).all() else -np.inf)
    return np.array(least)


def show_switching(learner: FlatLearner) -> Result:
    """Draw transitions between controllers: swims to goals, and the room of the scaffold."""
    body, swimmer, turner = learner.body, learner.swimmer, learner.turner
    lines: list[str] = []
    swims: dict[tuple[Any, str], Floats] = {}
    shares: dict[str, list[float]] = {}
    for goal in GOALS_L:
        for way in ("parameters", "lengths"):
            frames = swims[goal, way] = learner.swim_to(body.long * np.array(goal), way)
            missed = np.hypot(*(middle(body, frames[-1, 0]) / body.long - goal))
            lines.append(
                f"to {goal}, {way}: {len(frames) * FRAME_TU:.0f} tu, {missed:.2f} L away in the "
                f"end, folded {len(folds(body, frames))} times"
            )
    moments = np.linspace(30.0, 300.0, learner.effort.moments)
    for way in WAYS:
        shares[way] = []
        for bound in PASSED:
            old, new = (
                controller._replace(amplitude=bound / LARGEST * controller.amplitude)
                for controller in (swimmer, turner)
            )
            shares[way].append(float(np.mean(tightest(body, old, new, moments, way) <= 0)))
        lines.append(f"{way}: folded {percentages(PASSED, shares[way])}")

    def draw(page: Any) -> None:
        page.set_size_inches(7.4, 6.6)
        above, below = page.subfigures(2, 1, height_ratios=(1.3, 1.0))
        skin, axes = Skin(body), dict(zip(GOALS_L, above.subplots(1, 2), strict=True))
        for (goal, way), frames in swims.items():
            axis, path = axes[goal], middle(body, frames[:, 0]) / body.long
            axis.plot(*path.T, color=COLOURS[way], linewidth=1.6, label=way)
            for k in np.linspace(0, len(frames) - 1, 7).astype(int)[1:]:
                draw_fish(axis, skin, frames[k, 0], COLOURS[way], 0.6)
            axis.plot(*path[folds(body, frames)].T, "x", color=BLACK, markersize=8)
        for goal, axis in axes.items():
            draw_fish(axis, skin, body.rest, BLACK)
            axis.plot(*goal, "o", color="#c00000", markersize=9)
            axis.set(aspect="equal", xlabel="L", ylabel="L")
            axis.margins(0.08)
        left, right = below.subplots(1, 2)
        hind = len(body.mirror) - 2
        for way in WAYS:
            muscles = passage(body, swimmer, turner, LATE_TU, way)
            time = LATE_TU + STEP_TU * np.arange(len(muscles))
            left.plot(time, muscles[:, hind] / body.length[hind], color=COLOURS[way], linewidth=1.2)
            right.plot(PASSED, 100 * np.array(shares[way]), "o-", color=COLOURS[way], label=way)
        left.set(xlabel="time, tu", ylabel="length over that at rest",
                 title="what a hind muscle is asked for")  # fmt: skip
        right.set(xlabel="greatest amplitude, share of length", ylabel="passages that fold, %",
                  ylim=(-3, 103), title=f"at {len(moments)} moments")  # fmt: skip
        right.legend(title="what passes linearly", title_fontsize=9)

    return Result(lines, draw)


def folds(body: FlatBody, frames: Floats) -> Any:
    """Find the frames in which the scaffold begins to fold."""
    tight = room(body, frames[:, 0])
    return np.flatnonzero((tight[1:] <= 0) & (tight[:-1] > 0))


def percentages(names: Any, shares: list[float]) -> str:
    """List shares beside their numbers: 0.06: 0%, 0.09: 2%."""
    return ", ".join(f"{name:g}: {share:.0%}" for name, share in zip(names, shares, strict=True))


LEVELS = np.round(np.arange(0.05, 0.61, 0.05), 2)
BOUNDS = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3)


def folded(body: FlatBody, level: float, number: int) -> float:
    """Count the fraction of random controllers of amplitude ``level`` that fold the body."""
    rng, muscles, bad = np.random.default_rng(7), len(body.mirror), 0
    for _ in range(number):
        point = rng.random(2 * muscles + 1)
        point[:muscles] = 1.0
        bad += not is_sound(body, swim_by(body, controller_at(body, point, level)))
    return bad / number


def show_folding(learner: FlatLearner) -> Result:
    """Plot the need for a bound of the amplitudes, and what is learned within one."""
    number, tries = learner.effort.folds, learner.effort.tries // 2
    shares = [folded(learner.body, level, number) for level in LEVELS]
    far = {}
    for bound in BOUNDS:
        runs = learner.learn_swims(tries, learner.effort.bound_seeds, bound)
        far[bound] = [run.scores.max() for run in runs]
    medians = [float(np.median(ways)) for ways in far.values()]
    learned = ", ".join(f"{b:g}: {way:.2f} L" for b, way in zip(BOUNDS, medians, strict=True))

    def draw(page: Any) -> None:
        page.set_size_inches(7.4, 3.0)
        left, right = page.subplots(1, 2)
        left.plot(LEVELS, 100.0 * np.array(shares), "o-", color=ORANGE)
        left.set(xlabel="amplitude of all muscles, share of length", ylabel="folded, %",
                 ylim=(-3, 103), title=f"{number} random controllers each")  # fmt: skip
        right.plot(BOUNDS, [*far.values()], "o", color=BLUE, alpha=0.6)
        right.plot(BOUNDS, medians, color=BLUE)
        right.set(xlabel="bound of the amplitudes, share of length", ylabel="way in 60 tu, L",
                  ylim=(0, None), title=f"learned in {tries} tries")  # fmt: skip

    lines = [f"amplitude: folded  {percentages(LEVELS, shares)}", f"bound: learned  {learned}"]
    return Result(lines, draw)


EXPERIMENTS: Mapping[str, Callable[[FlatLearner], Result]] = {
    "body": show_body,
    "integrators": show_integrators,
    "learning": show_learning,
    "swims": show_swims,
    "turns": show_turns,
    "switching": show_switching,
    "folding": show_folding,
}
