"""Screenshots and screen recordings during a dive."""

from collections.abc import Callable
from contextlib import ExitStack
from datetime import datetime
from fractions import Fraction
from pathlib import Path

import platformdirs

from subsea.base.arrays import Bytes
from subsea.base.errors import UserError
from subsea.base.files import check_file
from subsea.base.pictures import write_png
from subsea.media.frame_writers import FilmFormat, Write, film_writer, fitted_size

Pixels = Bytes  # (height, width, 3), top row first

FPS = 30
MAX_GAP_S = 3.0  # a longer gap between two pictures is cut


def pictures_folder(named: str = "") -> Path:
    """The folder of the settings, else subsea in the user's pictures."""
    return Path(named).expanduser() if named else platformdirs.user_pictures_path() / "subsea"


class ScreenCapture:
    """Writes pictures and films, and reports their names. A failing disk never ends the dive."""

    def __init__(
        self, folder: Path, tell: Callable[[str], None], now: Callable[[], datetime] = datetime.now
    ) -> None:
        """Write into `folder`, created when first needed; `tell` shows a line."""
        self._folder, self._tell, self._now = folder, tell, now
        self.wanted = False  # a picture of the next screen
        self._film: ExitStack | None = None  # while recording
        self._write: Write
        self._path = folder
        self._size = 0, 0
        self._seconds = 0.0  # of the film so far ...
        self._frames = 0  # ... and its frames

    @property
    def filming(self) -> bool:
        """True while a film is recorded: then `frame` needs every picture."""
        return self._film is not None

    @property
    def seconds(self) -> float:
        """Length of the film so far."""
        return self._seconds

    def picture(self, pixels: Pixels) -> None:
        """Write a picture of the current screen."""
        path = self._new(".png")
        try:
            write_png(path, pixels)
        except UserError as fault:
            self._tell(str(fault))
        else:
            self._tell(f"picture: {path}")

    def film(self, size: tuple[int, int]) -> None:
        """Begin a film of a screen of `size` (width, height), or end the current one."""
        if self._film is not None:
            self.end()
            return
        self._path, self._size = self._new(".mp4"), fitted_size("film", size)
        self._seconds, self._frames = 0.0, 0
        stack = ExitStack()
        try:
            if min(self._size) < 2:
                raise UserError("the window is too small for a film")
            check_file(self._path)
            reel = film_writer(self._path, self._size, FilmFormat(Fraction(FPS)))
            self._write = stack.enter_context(reel)
        except UserError as fault:
            self._tell(str(fault))
            return
        self._film = stack
        self._tell(f"filming: {self._path}")

    def frame(self, pixels: Pixels, elapsed_s: float) -> None:
        """Write the picture that is wanted, and add to the film.

        The pixels are shown `elapsed_s` after the last ones; a film has FPS frames a second.
        """
        if self.wanted:
            self.wanted = False
            self.picture(pixels)
        if self._film is None:
            return
        width, height = self._size
        if (fitted_size("film", (pixels.shape[1], pixels.shape[0]))) != self._size:
            self.end("the size of the window changed")
            return
        if self._frames:
            self._seconds += min(elapsed_s, MAX_GAP_S)
        try:
            while self._frames <= self._seconds * FPS:
                self._write(self._frames, pixels[:height, :width])
                self._frames += 1
        except OSError as fault:
            self._give_up(fault)

    def end(self, why: str = "") -> None:
        """End the film, if there is one, and report its name."""
        if self._film is None:
            return
        if not self._frames:
            self._give_up(UserError("ended before the first picture", file=self._path))
            return
        film, self._film = self._film, None
        try:
            film.close()
        except (UserError, OSError) as fault:
            self._tell(str(fault))
            return
        length = f"{self._frames / FPS:.1f} s"
        self._tell(f"film of {length}{': ' * bool(why)}{why}: {self._path}")

    def _give_up(self, fault: Exception) -> None:
        """Discard the film and report why."""
        film, self._film = self._film, None
        try:
            if film is not None:
                film.__exit__(type(fault), fault, fault.__traceback__)
        except (UserError, OSError) as other:
            self._tell(str(other))
        else:
            self._tell(str(fault))

    def _new(self, suffix: str) -> Path:
        """An unused name with date and time."""
        stem = f"subsea-{self._now():%Y-%m-%d-%H%M%S}"
        path, number = self._folder / f"{stem}{suffix}", 1
        while path.exists():
            number += 1
            path = self._folder / f"{stem}-{number}{suffix}"
        return path
