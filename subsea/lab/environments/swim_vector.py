"""Thousands of swimming bodies at once, as a Gymnasium vector environment."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from subsea.base.arrays import Array, Bools
from subsea.base.errors import UserError
from subsea.lab.environments.swim_school import (
    ACTION_SPACE,
    OBSERVATION_SPACE,
    Exercise,
    SwimSchool,
    checked_actions,
)
from subsea.lab.environments.swim_tasks import Reward


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
        self.single_action_space, self.action_space = (
            ACTION_SPACE,
            batch_space(ACTION_SPACE, num_envs),
        )
        self.single_observation_space = OBSERVATION_SPACE
        self.observation_space = batch_space(OBSERVATION_SPACE, num_envs)
        self._all = np.arange(num_envs)
        self._randoms: list[np.random.Generator] = []
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
        seeds = self._seeds(seed)
        if not self._randoms:
            self._randoms = [seeding.np_random(one)[0] for one in seeds]
        else:
            for i, one in enumerate(seeds):
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
