"""`subsea film`: a tour without a window."""

import time
from pathlib import Path

from tqdm import tqdm

from subsea import interrupts
from subsea.app.console import say
from subsea.app.reels import check_reel, open_reel
from subsea.app.start import headless, picture_maker, start_world
from subsea.app.timing import sentence
from subsea.app.tour import Tour
from subsea.frame import pack
from subsea.ocean import step
from subsea.render.quality import PRESETS
from subsea.scenario import load_scenario
from subsea.view.levels import nothing_drawn
from subsea.view.rig import views
from subsea.view.rigs import cockpit, display_rig
from subsea.view.stereo import Stereo
from subsea.view.surround import Surround
from subsea.world import TICK_S


def film(
    out: Path,
    scenario: str,
    display: str,
    stereo: Stereo,
    surround: Surround,
    seconds: float,
    fps: float,
    size: tuple[int, int],
    quality: str,
    seed: int | None,
) -> int:
    """Film `seconds` of the tour at `fps` into `out`; a single picture is taken at its end.

    `quality` is the name of a preset.

    Returns the exit code. Ctrl-C keeps what was filmed so far. Prints the frame times: ticks
    of the world, packing, drawing and reading back, without the encoding of the film.
    """
    kind = check_reel(out)
    if kind == "film":
        size = size[0] - size[0] % 2, size[1] - size[1] % 2  # yuv420p halves both sides
    instants = [k / fps for k in range(max(round(seconds * fps), 1))]
    if kind == "picture":
        instants = [seconds]
    load_scenario(scenario)
    preset, rig = PRESETS[quality], display_rig(display, size, stereo, surround)
    durations: list[float] = []
    try:
        with headless() as context:
            world, tour = start_world(scenario, seed), Tour()
            with (
                interrupts.deferred() as check,
                picture_maker(context, world, rig, preset) as renderer,
                open_reel(out, size, fps) as write,
            ):
                say(f"filming to {out}")
                memory = nothing_drawn(len(world.state.fishes.species))
                for instant in tqdm(instants, unit="frame", disable=None):
                    start = time.perf_counter()
                    ticks, alpha = divmod(instant / TICK_S, 1.0)
                    check()
                    while world.state.tick < ticks + 1:  # the first is the start of the film
                        check()
                        step(world, tour.helm(world))
                    observer = cockpit(world.state.submarine, alpha)
                    packet = pack(
                        world, views(rig, observer), alpha,
                        detail=preset.detail, growth=preset.growth, memory=memory,
                    )  # fmt: skip
                    renderer.draw(packet)
                    picture = renderer.read_pixels()
                    drawn = time.perf_counter()
                    write(picture)
                    durations.append(drawn - start)
    except KeyboardInterrupt:
        _report(out, kind, durations)
        raise
    _report(out, kind, durations)
    return 0


def _report(out: Path, kind: str, durations: list[float]) -> None:
    """Tell what lies in `out` now; nothing where no picture was written."""
    if durations:
        print(f"{out}: {'written' if kind == 'picture' else sentence(durations)}")
