"""`subsea film`: a tour without a window."""

import time
from pathlib import Path

from tqdm import tqdm

from subsea.app.console import say
from subsea.app.reels import check_reel, open_reel
from subsea.app.start import start_headless, start_world
from subsea.app.timing import sentence
from subsea.app.tour import tour_helm
from subsea.frame import pack
from subsea.ocean import step
from subsea.view.rigs import cockpit, views_for
from subsea.world import TICK_S

SAMPLES = 4  # per pixel, on any renderer: a film has the time


def film(
    out: Path,
    scenario: str,
    display: str,
    seconds: float,
    fps: float,
    size: tuple[int, int],
    seed: int | None,
) -> int:
    """Film `seconds` of the tour at `fps` into `out`; a single picture is taken at its end.

    Returns the exit code. Ctrl-C keeps what was filmed so far. Prints the frame times: ticks
    of the world, packing, drawing and reading back, without the encoding of the film.
    """
    kind = check_reel(out)
    if kind == "film":
        size = size[0] - size[0] % 2, size[1] - size[1] % 2  # yuv420p halves both sides
    instants = [k / fps for k in range(max(round(seconds * fps), 1))]
    if kind == "picture":
        instants = [seconds]
    world = start_world(scenario, seed)
    durations: list[float] = []
    try:
        with (
            start_headless(world, size, samples=SAMPLES) as (_, renderer),
            open_reel(out, size, fps) as write,
        ):
            say(f"filming to {out}")
            for instant in tqdm(instants, unit="frame", disable=None):
                start = time.perf_counter()
                ticks, alpha = divmod(instant / TICK_S, 1.0)
                while world.state.tick < ticks + 1:  # the first tick is the start of the film
                    step(world, tour_helm(world))
                views = views_for(display, size, cockpit(world.state.submarine, alpha))
                renderer.draw(pack(world, views, alpha))
                picture = renderer.read_pixels()
                durations.append(time.perf_counter() - start)
                write(picture)
    finally:
        if durations:
            print(f"{out}: {'written' if kind == 'picture' else sentence(durations)}")
    return 0
