"""`subsea/Swim-v0`: one fish learns to use its muscles and fins (docs/how-to/environments.md).

Pictures of one swimming body, drawn by the renderer without a window.
"""

from typing import Any

import gymnasium
import numpy as np

from subsea.base.arrays import Array, Bytes
from subsea.base.errors import UserError
from subsea.biomechanics.body import build_body
from subsea.biomechanics.solver import TICK_S
from subsea.fish.paint import paint
from subsea.fish.skinning import couple, place
from subsea.fish.species import Species
from subsea.fish.surface import rest_control_points
from subsea.lab.environments.swim_school import (
    ACTION_SPACE,
    OBSERVATION_SPACE,
    Exercise,
    SwimSchool,
    checked_actions,
)
from subsea.lab.environments.swim_tasks import Reward
from subsea.rendering.fish.preview import FishPreview, Orbit
from subsea.rendering.gl.context import headless_context

ONE = np.zeros(1, np.int64)


class SwimEnv(gymnasium.Env[Array, Array]):
    """One simulated body of a species in still water.

    Actions (16,) float32 from -1 to 1: 0-11 contract the muscles, from relaxed at -1 to the
    greatest contraction of the species' own controllers at 1; 12 and 13 turn the left and the right
    pectoral fin, edge-on at 0 and broadside at ±1, up at the leading edge above 0; 14 and 15 move
    them 0.05 body lengths ahead (1) or back (-1). Observations (160,) float32 are clipped to ±10.
    docs/how-to/environments.md has the tables, the tasks and the rewards.

    An episode ends (``terminated``, ``info["burst"]``) when the body loses its shape.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012

    def __init__(
        self,
        species: str = "fusilier",
        task: str = "speed",
        reward: Reward | None = None,
        frame_skip: int = 1,
        render_mode: str | None = None,
    ) -> None:
        """Make a body; UserError for an unknown species, task or render mode.

        ``task`` is one of `swim_tasks.TASKS`, ``reward`` replaces its reward. A step lasts
        ``frame_skip`` ticks of 0.033 s.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise UserError(f"render_mode = {render_mode!r}; expected 'rgb_array' or None")
        self._school = SwimSchool(1, Exercise(species, task, reward, frame_skip))
        self.action_space, self.observation_space = ACTION_SPACE, OBSERVATION_SPACE
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1.0 / (frame_skip * TICK_S))}
        self._picture: Any = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode at rest, slightly disturbed; ``options`` are ignored."""
        super().reset(seed=seed)
        self._school.begin(ONE, [self.np_random])
        return self._school.bodies.observed[0].copy(), self._info()

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Swim one step; ValueError for an action of another shape or that is not finite."""
        actions = checked_actions(action, ACTION_SPACE.shape)[None]
        reward = self._school.step(ONE, actions, [self.np_random])
        burst = not self._school.bodies.sound[0]
        info = self._info()
        return self._school.bodies.observed[0].copy(), reward.item(), burst, False, info

    def render(self) -> Bytes | None:
        """The body (360, 640, 3) as the renderer draws it, from a fixed direction.

        UserError without OpenGL. None unless ``render_mode`` is "rgb_array".
        """
        if self.render_mode is None:
            return None
        if self._picture is None:
            from subsea.lab.environments.swim import SwimPicture

            self._picture = SwimPicture(self._school.species)
        return self._picture.draw(self._school.bodies.x[0])

    def close(self) -> None:
        """Free what drawing uses."""
        if self._picture is not None:
            self._picture.release()
            self._picture = None
        self._school.close()

    def _info(self) -> dict[str, Any]:
        bodies = self._school.bodies
        return {
            "burst": not bodies.sound[0],
            "toward": bodies.total_toward.item(),
            "work": bodies.total_work.item(),
        }


SIZE = (640, 360)
ORBIT = Orbit(turn=0.3, tilt=0.6, zoom=0.8)  # from the left and above, with room to turn


class SwimPicture:
    """A species, its skin and a headless context; UserError without OpenGL."""

    def __init__(self, species: Species) -> None:
        """Upload the species."""
        assert species.muscles
        body = build_body(species.muscles.body)
        rest = rest_control_points(species.surface, species.length_cm, body.rest[0, 0])
        self._coupling = couple(species.surface.coupling, body.rest, rest)
        self._context = headless_context()
        self._fish = FishPreview(self._context, species, paint(species))

    def draw(self, x: Array) -> Bytes:
        """The body (360, 640, 3) with nodes (23, 3) in world axes, in the middle of the picture."""
        points = place(self._coupling, x) - 0.5 * (x[5] + x[7])
        self._fish.draw(points, ORBIT, SIZE)
        return np.ascontiguousarray(self._fish.read_pixels())

    def release(self) -> None:
        """Free every OpenGL object."""
        self._fish.release()
        self._context.release()
