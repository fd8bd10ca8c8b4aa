"""Film a flat fish as KS did: an explosion (movie 1), a learned swim (2), a way to a goal (4)."""

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from capture.flat.controllers import FRAME_TU, STEP_TU, controller_at, swim_by
from capture.flat.drawing import BLUE, ORANGE, Skin, draw_scaffold
from capture.flat.experiments import explosion
from capture.flat.lessons import FlatLearner, best_first
from capture.flat.physics import middle
from capture.flat.scaffold import FlatBody
from subsea.base.files import replacing
from subsea.base.pictures import Pixels
from subsea.biomechanics.body import Floats

SIZE = (800, 500)  # pixels; H.264 needs even numbers
RATE = Fraction(30)  # pictures a second: of motion in water one for each stored state, as in life
SLOWER = 3  # pictures of each step of the explosion, which is over in 60
GOAL_L = (-3.5, -4.5)  # body lengths ahead and to the left


class FilmPanel(NamedTuple):
    """A panel of a film."""

    title: str
    frames: Floats  # (frames, 2, n, 2)
    goal: tuple[float, float] | None = None  # body lengths
    picture_tu: float = FRAME_TU  # between two frames


def explosion_scenes(learner: FlatLearner) -> list[FilmPanel]:
    """Swim with both of Euler's methods, slowly (KS movie 1)."""
    both = explosion(learner)
    return [
        FilmPanel(
            f"{name} Euler, steps of {STEP_TU} tu",
            np.repeat(frames[:100], SLOWER, axis=0),
            picture_tu=STEP_TU / SLOWER,
        )
        for name, frames in zip(("explicit", "implicit"), both, strict=True)
    ]


def swim_scenes(learner: FlatLearner) -> list[FilmPanel]:
    """Swim before and after learning (KS movie 2)."""
    best = best_first(learner.swims)[0]
    tries = {
        "before learning": best.points[0],
        f"after {len(best.points)} tries": best.winner,
    }
    return [
        FilmPanel(name, swim_by(learner.body, controller_at(learner.body, point)))
        for name, point in tries.items()
    ]


def goal_scenes(learner: FlatLearner) -> list[FilmPanel]:
    """Swim to a red point by three controllers (KS movie 4)."""
    frames = learner.swim_to(learner.body.long * np.array(GOAL_L), longest_tu=240.0)
    return [FilmPanel("to the red point", frames, GOAL_L)]


FILMS: Mapping[str, Callable[[FlatLearner], list[FilmPanel]]] = {
    "explosion": explosion_scenes,
    "swim": swim_scenes,
    "goal": goal_scenes,
}


def pictures(body: FlatBody, scenes: list[FilmPanel]) -> Iterator[Pixels]:
    """Draw the frames of scenes above each other; a fish that is out of all bounds vanishes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    page, skin = Figure(figsize=(SIZE[0] / 100, SIZE[1] / 100), dpi=100), Skin(body)
    canvas = FigureCanvasAgg(page)
    axes = page.subplots(len(scenes), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    paths = [middle(body, scene.frames[:, 0]) / body.long for scene in scenes]
    parts: list[tuple[Any, ...]] = []
    for axis, scene in zip(axes, scenes, strict=True):
        axis.set_title(scene.title, loc="left")
        if scene.goal:
            axis.plot(*scene.goal, "o", color="#c00000", markersize=9)
        (path,) = axis.plot([], [], color=ORANGE, linewidth=1.2)
        (shape,) = axis.fill([], [], facecolor=BLUE, edgecolor=BLUE, alpha=0.4)
        parts.append((path, shape, *draw_scaffold(axis, body, body.rest, 0.8)))
    seen = np.concatenate([path[np.abs(path).max(axis=1) < 20] for path in paths])
    low, high = seen.min(axis=0) - 0.8, seen.max(axis=0) + 0.8
    axes[0].set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    for axis in axes:
        axis.set(aspect="equal", ylabel="L")
    muscles = len(body.mirror)
    for k in range(max(len(scene.frames) for scene in scenes)):
        for scene, path, (way, shape, thin, thick) in zip(scenes, paths, parts, strict=True):
            x = scene.frames[min(k, len(scene.frames) - 1), 0] / body.long
            lines = x[body.units]
            way.set_data(*path[: k + 1].T)
            shape.set_xy(skin.outline(x))
            thin.set_segments(lines[muscles:])
            thick.set_segments(lines[:muscles])
        axes[-1].set_xlabel(f"ahead, L; {k * scenes[0].picture_tu:.1f} tu")
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def write_film(learner: FlatLearner, name: str, path: Path) -> None:
    """Write one of the films as H.264, whole or not at all."""
    import av

    scenes = FILMS[name](learner)
    with (
        replacing(path) as temporary,
        av.open(str(temporary), "w", format="mp4", options={"movflags": "+faststart"}) as container,
    ):
        stream: Any = container.add_stream("libx264", rate=RATE, options={"crf": "19"})
        (stream.width, stream.height), stream.pix_fmt = SIZE, "yuv420p"
        for picture in pictures(learner.body, scenes):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode(None))
