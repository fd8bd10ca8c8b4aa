"""`subsea/Swim-v0`: fishes learn to use muscles and fins, one or thousands at once.

docs/how-to/environments.md describes actions, observations, tasks and rewards.
"""

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from subsea.base.arrays import Array, Bools, Bytes
from subsea.base.errors import UserError
from subsea.biomechanics.body import build_body
from subsea.biomechanics.solver import TICK_S
from subsea.fish.paint import paint
from subsea.fish.skinning import couple, place
from subsea.fish.species import Species
from subsea.fish.surface import rest_control_points
from subsea.lab.environments.showing import RENDER_MODES, Shown, check_render_mode
from subsea.lab.environments.swim_school import (
    ACTION_SPACE,
    OBSERVATION_SPACE,
    Exercise,
    Reward,
    SwimSchool,
    checked_actions,
)
from subsea.rendering.fish.preview import FishPreview, Orbit
from subsea.rendering.gl.context import headless_context

ONE = np.zeros(1, np.int64)
SIZE = (640, 360)  # of a picture
ORBIT = Orbit(turn=0.3, tilt=0.6, zoom=0.8)  # from the left and above, with room to turn


class SwimEnv(gymnasium.Env[Array, Array]):
    """One simulated body of a species in still water.

    Actions (16,) float32 from -1 to 1: 0-11 contract the muscles, from relaxed at -1 to the
    greatest contraction of the species' own controllers at 1; 12 and 13 turn the left and the right
    pectoral fin, edge-on at 0 and broadside at ±1, up at the leading edge above 0; 14 and 15 move
    them 0.05 body lengths ahead (1) or back (-1). Observations (160,) float32 are clipped to ±10.
    docs/how-to/environments.md has the tables, the tasks and the rewards.

    An episode ends (``terminated``, ``info["burst"]``) when the body loses its shape.
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 30}  # noqa: RUF012

    def __init__(
        self,
        species: str = "fusilier",
        task: str = "speed",
        reward: Reward | None = None,
        frame_skip: int = 1,
        render_mode: str | None = None,
    ) -> None:
        """Make a body; UserError for an unknown species, task or render mode.

        ``task`` is one of `swim_school.TASKS`, ``reward`` replaces its reward. A step lasts
        ``frame_skip`` ticks of 0.033 s.
        """
        check_render_mode(render_mode)
        self._school = SwimSchool(1, Exercise(species, task, reward, frame_skip))
        self.action_space, self.observation_space = ACTION_SPACE, OBSERVATION_SPACE
        self.render_mode = render_mode
        fps = 1.0 / (frame_skip * TICK_S)
        self.metadata = {**self.metadata, "render_fps": round(fps)}
        self._picture: Any = None
        self._shown = Shown(render_mode, fps)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode at rest, slightly disturbed; ``options`` are ignored."""
        super().reset(seed=seed)
        self._school.begin(ONE, [self.np_random])
        self._shown.update(self._draw)
        return self._school.bodies.observed[0].copy(), self._info()

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Swim one step; ValueError for an action of another shape or that is not finite."""
        actions = checked_actions(action, ACTION_SPACE.shape)[None]
        reward = self._school.step(ONE, actions, [self.np_random])
        burst = not self._school.bodies.sound[0]
        info = self._info()
        self._shown.update(self._draw)
        return self._school.bodies.observed[0].copy(), reward.item(), burst, False, info

    def render(self) -> Bytes | None:
        """Draw the body (360, 640, 3) as the renderer draws it, from a fixed direction.

        UserError without OpenGL. None unless ``render_mode`` is "rgb_array". With "human", `reset`
        and `step` show it in a window.
        """
        return self._shown.render(self._draw)

    def _draw(self) -> Bytes:
        if self._picture is None:
            self._picture = SwimPicture(self._school.species)
        return self._picture.draw(self._school.bodies.x[0])

    def close(self) -> None:
        """Free what drawing uses."""
        self._shown.close()
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


class SwimVectorEnv(VectorEnv[Array, Array, NDArray[Any]]):
    """``num_envs`` bodies, each as in `SwimEnv`, over arrays and threads.

    The same seeds give the same episodes as SwimEnv, bit for bit, on any number of threads. After
    its episode has ended, a body begins the next one in the next step, whose action is ignored and
    whose reward is 0.
    """

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        species: str = "fusilier",
        task: str = "speed",
        reward: Reward | None = None,
        frame_skip: int = 1,
        threads: int | None = None,
    ) -> None:
        """Make ``num_envs`` bodies; parameters as of `SwimEnv`.

        An episode is truncated after ``max_episode_steps`` steps. ``threads`` None: one for each
        core.
        """
        self.num_envs = num_envs
        self._school = SwimSchool(num_envs, Exercise(species, task, reward, frame_skip), threads)
        self._limit = np.inf if max_episode_steps is None else max_episode_steps
        self.single_action_space = ACTION_SPACE
        self.action_space = batch_space(ACTION_SPACE, num_envs)
        self.single_observation_space = OBSERVATION_SPACE
        self.observation_space = batch_space(OBSERVATION_SPACE, num_envs)
        self._all = np.arange(num_envs)
        self._randoms = [seeding.np_random()[0] for _ in range(num_envs)]
        self._ended = np.zeros(num_envs, np.bool_)
        self._steps = np.zeros(num_envs, np.int64)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Array, dict[str, Any]]:
        """Begin all episodes. Body i gets seed ``seed`` + i, or its own of a list.

        Without a seed it continues its random numbers. ``options`` are ignored. UserError for a
        list of another length.
        """
        for i, one in enumerate(self._seeds(seed)):
            if one is not None:
                self._randoms[i] = seeding.np_random(one)[0]
        self._ended[:] = False
        self._steps[:] = 0
        self._school.begin(self._all, self._randoms)
        return self._school.bodies.observed.copy(), self._infos(self._ended)

    def step(
        self, actions: Array
    ) -> tuple[Array, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Swim one step; ValueError for actions of another shape or that are not finite."""
        actions = checked_actions(actions, self.action_space.shape or ())
        again, who = np.flatnonzero(self._ended), np.flatnonzero(~self._ended)
        if len(again):
            self._school.begin(again, self._randoms)
        rewards = self._school.step(who, actions, self._randoms)
        rewards[again] = 0.0
        self._steps += 1
        self._steps[again] = 0
        terminated = self._school.burst()
        truncated = self._steps >= self._limit
        self._ended = terminated | truncated
        return (
            self._school.bodies.observed.copy(), rewards, terminated, truncated,
            self._infos(terminated),
        )  # fmt: skip

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads."""
        self._school.close()

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int):
            return [seed + i for i in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise UserError(f"{len(seed)} seeds for {self.num_envs} bodies; expected one for each")
        return list(seed)

    def _infos(self, burst: Bools) -> dict[str, Any]:
        bodies, everyone = self._school.bodies, np.ones(self.num_envs, np.bool_)
        infos = {
            "burst": burst.copy(),
            "toward": bodies.total_toward.copy(),
            "work": bodies.total_work.copy(),
        }
        return {**infos, **{f"_{name}": everyone for name in infos}}


class SwimPicture:
    """A species, its skin and a headless context; UserError without OpenGL."""

    def __init__(self, species: Species) -> None:
        """Upload the species."""
        assert species.muscles
        body = build_body(species.muscles.body)
        rest = rest_control_points(species.surface, species.length_cm, body.rest[0, 0])
        self._coupling = couple(species.surface.coupling, body.rest, rest)
        self._context = headless_context()
        with self._context:  # detached at its end: no window could open in this thread otherwise
            self._fish = FishPreview(self._context, species, paint(species))

    def draw(self, x: Array) -> Bytes:
        """Draw the body with world nodes (23, 3), in the middle of a picture (360, 640, 3)."""
        points = place(self._coupling, x) - 0.5 * (x[5] + x[7])
        with self._context:
            self._fish.draw(points, ORBIT, SIZE)
            return np.ascontiguousarray(self._fish.read_pixels())

    def release(self) -> None:
        """Free every OpenGL object."""
        with self._context:
            self._fish.release()
        self._context.release()
