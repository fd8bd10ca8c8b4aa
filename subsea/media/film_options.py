"""The options of `subsea film`."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from subsea.media.exposure import PINHOLE, Exposure
from subsea.scenario.schema import AUTOPILOT
from subsea.view.retina import AHEAD, FIELD_DEG, Gaze
from subsea.view.stereo import EYES, Stereo
from subsea.view.surround import ALL_ROUND, Surround


@dataclass(frozen=True, kw_only=True)
class FilmOptions:
    """The filmed dive, and the part of it."""

    out: Path
    scenario: str = "peaceful"
    changes: Sequence[str] = ()  # to the scenario, as in --set
    seed: int | None = None  # None: the scenario's
    fish: int | None = None  # total number; None: the scenario's
    tour: str = AUTOPILOT  # one of the scenario's, "auto" or "directed"
    start: float = 0.0  # s of the dive before the first frame
    seconds: float | None = None  # None: to the end of the tour
    fps: float = 30.0
    size: tuple[int, int] = (1280, 720)  # of one picture, pixels
    quality: str = "high"  # the name of a preset
    force: bool = False  # replace a file of another kind


@dataclass(frozen=True, kw_only=True)
class TourFilmOptions(FilmOptions):
    """A film of the submarine's windows."""

    display: str = "mono"
    stereo: Stereo = EYES
    surround: Surround = ALL_ROUND
    theatre: str | None = None  # instead of one picture of `size`, a film for each window
    shrink: int = 1  # the theatre's width and height are divided by this
    show: Sequence[str] = ()  # diagrams over the sea
    wireframe: bool = False
    mute: bool = False  # a film without sound
    sound_layout: str = "stereo"  # one of `sound.space.LAYOUTS`
    audio: Path | None = None  # the sound alone, a WAV file
    audio_stems: Path | None = None  # a folder with the sound of each group
    follow: str | None = None  # a fish to look at from behind, as long as it lives
    exposure: Exposure = PINHOLE  # motion blur and depth of field


@dataclass(frozen=True, kw_only=True)
class EyeFilmOptions(FilmOptions):
    """Labelled frames of a fish's view."""

    eyes: str  # the fish
    gaze: Gaze = AHEAD
    field_deg: float = FIELD_DEG
    see_brightness: bool = False  # the fish reacts to the light in its eyes
