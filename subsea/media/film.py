"""`subsea film`: a tour without a window."""

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from subsea.core import interrupts
from subsea.core.console import counted, say
from subsea.core.durations import sentence
from subsea.core.progress import progress
from subsea.dive.captions import caption_of, titled
from subsea.dive.directed_camera import check_tour, guided, leapt
from subsea.dive.start import headless, picture_maker, start_world
from subsea.dive.theatre_setup import chosen_rig, told
from subsea.dive.tour import Steer
from subsea.frame.diagrams import DiagramBuilder, PlacedLabel, place_labels
from subsea.frame.packet import pack
from subsea.media.dry_run import rehearsed_s
from subsea.media.frame_writers import check_reel, fitting, frame_rate, open_reels, written_to
from subsea.media.resume_manifest import begin, description, missing_frames
from subsea.media.video_metadata import NO_TAGS, tags_for
from subsea.render.output.quality import PRESETS
from subsea.scenario.fish_lookup import find_fish
from subsea.scenario.schema import AUTOPILOT, DIRECTED, Scenario, load_scenario
from subsea.submarine.course import course_of
from subsea.view.display_rigs import cockpit
from subsea.view.follow import FollowCamera, follow_fish
from subsea.view.levels import empty_lod_state
from subsea.view.rig import CameraPose, views
from subsea.view.stereo import Stereo
from subsea.view.surround import Surround
from subsea.world.step import step
from subsea.world.world import TICK_S, World

Check = Callable[[], None]

UNTOLD_S = 10.0  # how long a film is if nobody says
LETTERS, SMALLEST_PX = 0.022, 9.0  # height of labels: a share of the picture's, and at least


def film(
    out: Path,
    scenario: str,
    display: str,
    stereo: Stereo,
    surround: Surround,
    seconds: float | None,
    fps: float,
    size: tuple[int, int],
    quality: str,
    seed: int | None,
    start: float = 0.0,
    tour: str = AUTOPILOT,
    theatre: str | None = None,
    shrink: int = 1,
    show: Sequence[str] = (),
    wireframe: bool = False,
    changes: Sequence[str] = (),
    follow: str | None = None,
) -> int:
    """Film `seconds` of the tour from `start` at `fps` into `out`; one picture shows its end.

    `tour` is one of the scenario's, which is filmed to its end if there are no `seconds`, so is
    what its directions show if it is "directed"; or "auto". `quality` is the name of a preset.
    A folder that holds a part of the film already gets what it lacks: the world is stepped through
    all frames, and all are packed, lest those that are drawn differ from those of one go.

    A `theatre` is filmed instead of one picture of `size`: a reel for each of its windows, of
    `shrink` times fewer pixels a side. The diagrams `show` are drawn over the sea, of which a
    `wireframe` has the edges of triangles. The fish called `follow` is filmed from behind, as
    long as it lives; the submarine goes on its tour as ever.

    Returns the exit code. Ctrl-C keeps what was filmed so far. Prints the frame times: ticks
    of the world, packing, drawing and reading back, without the encoding of the film.
    """
    chosen, source = load_scenario(scenario, changes)
    check_tour(chosen, tour)
    fish = None if follow is None else find_fish(follow, chosen)
    if seconds is None:
        seconds = length_s(chosen, source, seed, start, tour)
    kind = check_reel(out)
    size = fitting(kind, size)
    rig, windows = chosen_rig(display, size, stereo, surround, theatre, shrink)
    sizes = {name: fitting(kind, shown) for name, shown in zip(windows, rig.outputs, strict=True)}
    names = written_to(out, windows)
    rate = frame_rate(fps)
    times = [start + seconds] if kind == "picture" else instants(start, seconds, rate)
    missing = list(range(len(times)))
    if kind == "folder":
        take = description(
            source, changes, tour=tour, seed=seed, start=start, seconds=seconds, fps=fps, size=size,
            quality=quality, display=display, theatre=told(theatre), shrink=shrink,
            show=[*show], wireframe=wireframe, follow=fish,
            **stereo._asdict(), **surround._asdict(),
        )  # fmt: skip
        missing = missing_frames(out, take, windows, len(times))
        if not missing:
            print(f"{out}: complete, {counted(len(times), 'frame', 'frames')}")
            return 0
    preset = PRESETS[quality]
    durations: list[float] = []
    try:
        with ExitStack() as stack:
            context = stack.enter_context(headless())
            world = start_world(scenario, seed, changes=changes)
            steer = guided(world, tour)
            check = stack.enter_context(interrupts.deferred())
            renderer = stack.enter_context(picture_maker(context, world, rig, preset))
            renderer.wireframe = wireframe
            sketcher = DiagramBuilder(world)
            if kind == "folder":
                begin(out, take)
            # In a theatre every channel has two eyes, which no player knows.
            tags = tags_for(display) if theatre is None else NO_TAGS
            write = stack.enter_context(open_reels(out, sizes, rate, tags))
            say(_intent(names, len(times), missing))
            done = stack.enter_context(progress(len(times), "frame", len(times) - len(missing)))
            memory = empty_lod_state(len(world.state.fishes.species))
            wanted = set(missing)
            camera: FollowCamera | None = None
            observer: CameraPose | None = None

            reach(world, times[0], steer, check)
            for k, instant in enumerate(times[: missing[-1] + 1]):
                begun = time.perf_counter()
                alpha = reach(world, instant, steer, check)
                before, observer = observer, cockpit(world.state.submarine, alpha)
                if leapt(before, observer, float(1 / rate)):  # nothing fades into what comes
                    memory = empty_lod_state(len(world.state.fishes.species))
                if fish is not None and world.state.fishes.alive[fish]:
                    camera, observer = follow_fish(world, fish, alpha, camera)
                seen = views(rig, observer)
                drawing = sketcher.draw(show, seen, alpha)
                packet = pack(
                    world, seen, alpha, detail=preset.detail, growth=preset.growth,
                    memory=memory, lines=drawing.lines,
                )  # fmt: skip
                if k not in wanted:
                    renderer.choose(packet)
                    continue
                renderer.draw(packet)
                words = place_labels(rig, seen, drawing.labels)
                caption = caption_of(world, alpha)
                pictures = {}
                for number, (name, (width, height)) in enumerate(sizes.items()):
                    picture = lettered(renderer.read_pixels(number), words, number)
                    picture = titled(picture, rig, number, caption)
                    pictures[name] = picture[:height, :width]
                drawn = time.perf_counter()
                write(k, pictures)
                durations.append(drawn - begun)
                done()
    except KeyboardInterrupt:
        _report(names, kind, durations)
        raise
    _report(names, kind, durations)
    return 0


def length_s(
    scenario: Scenario, source: Path, seed: int | None, start: float, tour: str
) -> float:  # fmt: skip
    """How long a film is of which nobody says that: to the end of its tour, if that has one."""
    if tour == AUTOPILOT:
        return UNTOLD_S
    if tour == DIRECTED:
        return max(rehearsed_s(scenario, source, seed) - start, 0.0)
    return max(course_of(scenario, tour).seconds - start, 0.0)


def instants(start: float, seconds: float, rate: Fraction) -> list[float]:
    """When the frames of a film are, in seconds since the dive began; one at least."""
    return [start + float(k / rate) for k in range(max(round(seconds * rate), 1))]


def reach(
    world: World, instant: float, steer: Steer, check: Check, before: Check = lambda: None
) -> float:
    """Step the world until `instant` lies between its last two ticks; how far from the first.

    `before` is called before every tick; `check` also once at the beginning: it may raise.
    """
    ticks, alpha = divmod(instant / TICK_S, 1.0)
    check()
    while world.state.tick < ticks + 1:  # the first is the start of the film
        check()
        before()
        step(world, steer(world))
    return alpha


def lettered(
    picture: NDArray[np.uint8], words: Sequence[PlacedLabel], output: int
) -> NDArray[np.uint8]:
    """The picture (h, w, 3) of an `output` with its labels on it."""
    if not any(word.output == output for word in words):
        return picture
    from PIL import Image, ImageDraw, ImageFont

    image = Image.fromarray(picture)
    canvas = ImageDraw.Draw(image)
    tall = max(LETTERS * picture.shape[0], SMALLEST_PX)
    font = ImageFont.load_default(tall)
    for word in words:
        if word.output == output:
            canvas.text(
                (word.x, word.y), word.text, (235, 248, 255), font, anchor="mb",
                stroke_width=max(round(0.1 * tall), 1), stroke_fill=(0, 25, 40),
            )  # fmt: skip
    return np.asarray(image)


def _intent(names: str, frames: int, missing: list[int]) -> str:
    """What is going to be done, in words."""
    if len(missing) == frames:
        return f"filming to {names}"
    lacking = counted(len(missing), "frame", "frames")
    return f"filming to {names}: {lacking} of {frames} missing, from {missing[0]} on"


def _report(names: str, kind: str, durations: list[float]) -> None:
    """Tell what lies in the files of these names now; nothing where no picture was written."""
    if durations:
        print(f"{names}: {'written' if kind == 'picture' else sentence(durations)}")
