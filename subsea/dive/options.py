"""The options of a dive, in groups. Nothing here imports the world or draws.

Load a scenario into a world that is ready to run; draw without a window.
"""

import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from subsea.base.language import marked
from subsea.base.progress import say
from subsea.dive.settings import DEFAULTS, Settings
from subsea.dive.warm_up import warm_up
from subsea.frame.packet import make_scene, pack
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import cockpit, views_for
from subsea.view.rig import CameraRig
from subsea.view.stereo import EYES, Stereo
from subsea.view.surround import ALL_ROUND, Surround
from subsea.world.build import LIVE_REACH_CM, create_world
from subsea.world.step import step
from subsea.world.world import World

if TYPE_CHECKING:  # loaded only for a console
    from subsea.stage.console.options import ConsoleOptions

RetinaColours = Literal["colours", "identity", "range"]
RETINA_COLOURS: tuple[RetinaColours, ...] = ("colours", "identity", "range")


@dataclass(frozen=True)
class DisplayOptions:
    """The windows, the drawing of the sea in them, and diagrams over it."""

    mode: str = "mono"  # one of `view.display_rigs.DISPLAYS`, or HEADSET
    size: tuple[int, int] = (1280, 720)  # pixels of the one window; a theatre has its own
    fullscreen: bool = False
    stereo: Stereo = EYES
    surround: Surround = ALL_ROUND
    quality: str = "auto"  # one of `render.output.quality.CHOICES`
    target_ms: float | None = None  # frame time that "auto" holds; None: by the renderer
    diagrams: Sequence[str] = ()  # names of `frame.diagrams.DIAGRAMS`
    wireframe: bool = False


@dataclass(frozen=True)
class TheatreOptions:
    """The theatre that shows the dive."""

    name: str
    shrink: int = 1  # times fewer pixels a side
    node: str | None = None  # name of this computer; None: it shows all windows
    resumes: bool = True  # a master that is restarted goes on with the dive of its nodes


@dataclass(frozen=True)
class StartOptions:
    """The start of a dive: at the helm or on a fish, and the rate of time."""

    follow: str | None = None  # the fish to look at from behind
    eyes: str | None = None  # the fish to look through
    gaze: tuple[float, float] | None = None  # degrees right and up, of these eyes
    colours: RetinaColours | None = None  # of the pictures of the eyes
    teleop: bool = False  # the pilot steers the fish
    pace: float | None = None  # one of `timeline.RATES`; 0: time is paused


@dataclass(frozen=True)
class DiveOptions:
    """All options of `subsea dive`."""

    scenario: str
    changes: Sequence[str] = ()  # to the scenario, such as "fish.0.number=20"
    seed: int | None = None
    fish: int | None = None  # total number of fishes; None: the scenario's
    seconds: float | None = None  # the dive ends after; None: never
    tour: str | None = None  # begins at once; None: that of the settings, after their idle time
    kiosk: bool = False
    playlist: Path | None = None  # the file of a show, which chooses scenarios and tours
    see_brightness: bool = False  # a ridden fish reacts to the light in its eyes
    display: DisplayOptions = DisplayOptions()
    theatre: TheatreOptions | None = None
    start: StartOptions = StartOptions()
    settings: Settings = DEFAULTS
    settings_file: Path | None = None  # which a visitor's changes go to
    console: "ConsoleOptions | None" = None  # the presenter's


if TYPE_CHECKING:
    from subsea.rendering.output.quality import Quality
    from subsea.rendering.renderer import Renderer

Say = Callable[[str], None]
WAKING = marked("waking the fishes")  # line on the progress


def start_world(
    scenario: str, seed: int | None = None, fish: int | None = None, tell: Say = say,
    motor: str | None = None, changes: Sequence[str] = (),
) -> World:  # fmt: skip
    """The world of a named scenario after its first tick and packet, with kernels compiled.

    The motor "playback" simulates no fish, "dynamics" every one as soon as its motion allows,
    None: as the scenario says. `changes` are those of `--set`.
    """
    chosen, path = load_scenario(scenario, changes)
    number = sum(shoal.number for shoal in chosen.fish) if fish is None else fish
    if motor is None:
        return ready_world(chosen, path, seed, tell, fish)
    live = number if motor == "dynamics" else 0
    return ready_world(chosen, path, seed, tell, fish, live, math.inf)


def ready_world(
    scenario: Scenario, source: Path, seed: int | None = None, tell: Say = say,
    fish: int | None = None, live: int | None = None, live_reach_cm: float = LIVE_REACH_CM,
) -> World:  # fmt: skip
    """The world of a scenario after its first tick and packet, with kernels compiled.

    `source` is the scenario's file; for the others see :func:`subsea.world.build.create_world`.
    """
    warm_up(tell)
    world = create_world(scenario, seed, fish, tell, live, live_reach_cm, str(source))
    tell(WAKING)
    wake(world)
    return world


def wake(world: World) -> None:
    """Make the first tick and packet of a world, which load its kernels."""
    step(world, NEUTRAL)
    pack(world, views_for("mono", (64, 64), cockpit(world.state.submarine, 1.0)), 1.0)


@contextmanager
def headless() -> Iterator[Any]:
    """An OpenGL context without a window; a UserError without OpenGL."""
    # Messages of Mesa would hide the line that says what to install.
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")
    from subsea.rendering.gl.context import headless_context

    context = headless_context()
    try:
        yield context
    finally:
        # Detach the context from this thread: no window could open otherwise.
        with context:
            pass
        context.release()


@contextmanager
def picture_maker(
    context: Any, world: World, rig: CameraRig, quality: "Quality"
) -> Iterator["Renderer"]:
    """A renderer for the pictures of a rig."""
    from subsea.rendering.renderer import Renderer

    renderer = Renderer(context, make_scene(world), rig, quality)
    try:
        yield renderer
    finally:
        renderer.release()
