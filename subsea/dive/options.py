"""The options of a dive, in groups. Nothing here imports the world or draws."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from subsea.dive.settings import DEFAULTS, Settings
from subsea.view.stereo import EYES, Stereo
from subsea.view.surround import ALL_ROUND, Surround

if TYPE_CHECKING:
    from subsea.dive.part import DivePart

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
    kiosk: bool = False  # only controls of visitors, and each visit starts over
    see_brightness: bool = False  # a ridden fish reacts to the light in its eyes
    display: DisplayOptions = DisplayOptions()
    start: StartOptions = StartOptions()
    settings: Settings = DEFAULTS
    settings_file: Path | None = None  # which a visitor's changes go to
    parts: "Sequence[DivePart]" = ()  # which wings add
