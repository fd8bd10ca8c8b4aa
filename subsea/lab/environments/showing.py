"""Pictures of environments: in a window for people, or as films of episodes."""

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any, SupportsFloat

import gymnasium
import numpy as np

from subsea.base.arrays import Bytes
from subsea.base.errors import UserError, unknown
from subsea.base.files import check_folder
from subsea.media.frame_writers import FilmFormat, film_writer, fitted_size, frame_rate

RENDER_MODES = ["human", "rgb_array"]
TITLE = "subsea"


def check_render_mode(mode: str | None) -> None:
    """Raise a UserError for an unknown mode."""
    if mode not in (None, *RENDER_MODES):
        raise unknown("render_mode", str(mode), RENDER_MODES)


class Shown:
    """Pictures of an environment in its render mode."""

    def __init__(self, mode: str | None, fps: float) -> None:
        """Refuse an unknown mode.

        It knows nothing of its environment: one without owners is freed at once, with its context,
        and not by the garbage collector while another context draws.
        """
        check_render_mode(mode)
        self._mode, self._fps = mode, fps
        self._window: Any = None

    def render(self, draw: Callable[[], Bytes]) -> Bytes | None:
        """Return the picture in the mode "rgb_array"; None in others."""
        return draw() if self._mode == "rgb_array" else None

    def update(self, draw: Callable[[], Bytes]) -> None:
        """Show the picture in the mode "human", at the environment's own speed.

        `draw` makes it, of the same size each time.

        Opens a window at first; one that a person has closed stays closed.
        """
        if self._mode != "human":
            return
        if self._window is None:
            from subsea.ui.picture_window import PictureWindow

            picture = draw()  # without OpenGL no window opens
            high, wide = picture.shape[:2]
            self._window = PictureWindow(
                TITLE, (wide, high), self._fps, 'render_mode="rgb_array" returns pictures'
            )
            self._window.show(picture)
        elif self._window.is_open:
            self._window.show(draw())

    def close(self) -> None:
        """Close the window."""
        if self._window is not None:
            self._window.close()
            self._window = None


def is_filmed(episode: int) -> bool:
    """Choose cubes below 1000, and then every thousandth episode, as Gymnasium does."""
    return bool(
        round(episode ** (1 / 3)) ** 3 == episode if episode < 1000 else episode % 1000 == 0
    )


class RecordVideo(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Write films of episodes, as `gymnasium.wrappers.RecordVideo` does, without MoviePy.

    Films are H.264 in ``FOLDER/PREFIX-episode-N.mp4`` or ``FOLDER/PREFIX-step-N.mp4``, at the
    environment's own speed.
    """

    def __init__(
        self,
        env: gymnasium.Env[Any, Any],
        video_folder: str | Path,
        episode_trigger: Callable[[int], bool] | None = None,
        step_trigger: Callable[[int], bool] | None = None,
        video_length: int = 0,
        name_prefix: str = "rl-video",
        fps: float | None = None,
    ) -> None:
        """Film the episodes and steps, counted from 0, for which a trigger returns True.

        Without triggers these are episodes 0, 1, 8, 27 … 729, 1000, 2000 … `video_length` is the
        most pictures of a film; 0: to the end of the episode. A UserError for a folder that cannot
        be written, a ValueError for an environment without pictures.
        """
        super().__init__(env)
        if env.render_mode != "rgb_array":
            raise ValueError(f"render_mode = {env.render_mode!r}, expected 'rgb_array'")
        if episode_trigger is None and step_trigger is None:
            episode_trigger = is_filmed
        self._folder = Path(video_folder)
        check_folder(self._folder)
        self._of_episode = episode_trigger or (lambda episode: False)
        self._of_step = step_trigger or (lambda step: False)
        self._most, self._prefix = video_length, name_prefix
        self._rate = frame_rate(fps or env.metadata.get("render_fps", 30))
        self._episode = self._step = -1
        self._film: ExitStack | None = None
        self._write: Any = None
        self._number = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode, and maybe a film."""
        seen = super().reset(seed=seed, options=options)
        self._episode += 1
        if not self._most:
            self._end()
        if self._of_episode(self._episode):
            self._begin(f"episode-{self._episode}")
        self._add()
        return seen

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Step the environment, and add a picture to the film."""
        told = super().step(action)
        self._step += 1
        if self._of_step(self._step):
            self._begin(f"step-{self._step}")
        self._add()
        return told

    def close(self) -> None:
        """Finish the film, and close the environment."""
        self._end()
        super().close()

    def _begin(self, name: str) -> None:
        self._end()
        self._film, self._write, self._number = ExitStack(), None, 0
        self._path = self._folder / f"{self._prefix}-{name}.mp4"

    def _add(self) -> None:
        """Add the present picture to the film, if there is one."""
        if self._film is None:
            return
        picture: Any = self.env.render()
        wide, high = fitted_size("film", (picture.shape[1], picture.shape[0]))
        if self._write is None:
            if not (wide and high):
                raise UserError("a film needs pictures of at least 2 by 2 pixels", file=self._path)
            film = film_writer(self._path, (wide, high), FilmFormat(self._rate))
            self._write = self._film.enter_context(film)
        self._write(self._number, np.ascontiguousarray(picture[:high, :wide]))
        self._number += 1
        if self._number == self._most:
            self._end()

    def _end(self) -> None:
        film, self._film = self._film, None
        if film is not None:
            film.close()
