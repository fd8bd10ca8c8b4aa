"""A swimming fish for previews: simulated with its own controllers, or moved by its spine.

It keeps swimming while it is edited, and restarts if it loses its shape. The view follows it,
averaged over a beat.
"""

from collections import deque
from typing import Literal, get_args

import msgspec
import numpy as np

from subsea.base.arrays import Array
from subsea.biomechanics.body import MUSCLES, Body, body_frame, build_body
from subsea.biomechanics.body_plan import GRADES, Muscles
from subsea.biomechanics.controllers import LEFT, RIGHT, bend_contraction, swim_contraction
from subsea.biomechanics.simulation import BodyState, at_rest, is_sound, simulate
from subsea.biomechanics.solver import STEPS_PER_TICK, TICK_S
from subsea.fish.skinning import couple, place
from subsea.fish.species import Species
from subsea.fish.spine import (
    MIDDLES,
    SpineGait,
    SpinePlan,
    bend_points,
    flap_wings,
    keep_height,
    pose_spine,
)
from subsea.fish.surface import (
    SurfacePlan,
    along,
    fit_control_points,
    rest_control_points,
    rest_surface,
)

Mode = Literal["rest", "slow", "medium", "fast", "left", "right"]
MODES: tuple[Mode, ...] = get_args(Mode)
EASE = 0.06  # share of the way to the target amplitude and bend, per tick
MOST_TICKS = 4  # caught up after a slow frame
STILL = 1e-3  # contraction below this is rest


class Swimmer:
    """A fish in motion, as control points."""

    def __init__(self, species: Species) -> None:
        """Begin at rest, and swim at grade medium."""
        self.mode: Mode = "medium"
        self._left_s = 0.0  # time not simulated yet
        self._phase, self._amplitude, self._bend = 0.0, 0.0, 0.0
        self._gait = np.zeros(3)  # contractions and lag of the beat
        self._state: BodyState | None = None
        self._beat: deque[tuple[Array, Array]] = deque(maxlen=1)  # origins, headings
        self.contraction = np.zeros(MUSCLES)  # shares of the rest length
        self.reshape(species)

    def reshape(self, species: Species) -> None:
        """Continue as another species, from rest if the length of its scaffold differs."""
        self._muscles, self._spine, self._surface = species.muscles, species.spine, species.surface
        if self._muscles:
            body = build_body(self._muscles.body)
            if self._state is None or np.ptp(body.rest[:, 0]) != np.ptp(self._body.rest[:, 0]):
                self._begin(body)
            self._body: Body = body
            rest = rest_control_points(species.surface, species.length_cm, body.rest[0, 0])
            self._coupling = couple(species.surface.coupling, body.rest, rest)
            ticks = self._muscles.swim.at("medium").ticks_per_beat
            if self._beat.maxlen != ticks + 1:
                self._beat = deque(self._beat, maxlen=ticks + 1)
        self._now = self._then = self._points()

    def advance(self, elapsed_s: float) -> Array:
        """Swim on; return control points (426, 3), cm, in axes ahead, up and right of the fish."""
        self._left_s = min(self._left_s + elapsed_s, MOST_TICKS * TICK_S)
        while self._left_s >= TICK_S:
            self._left_s -= TICK_S
            self._then = self._now
            self._tick()
            self._now = self._points()
        share = self._left_s / TICK_S
        return np.asarray((1.0 - share) * self._then + share * self._now)

    @property
    def can_turn(self) -> bool:
        """True if it can turn; a spine-driven fish swims straight here."""
        return self._muscles is not None

    @property
    def moving(self) -> bool:
        """True if the next frame differs."""
        return self.mode != "rest" or self._amplitude > STILL or abs(self._bend) > STILL

    def _begin(self, body: Body) -> None:
        self._state = at_rest(body)
        self._beat.clear()
        self.contraction = np.zeros(MUSCLES)

    def _tick(self) -> None:
        goal, bend = self._goal()
        self._amplitude += EASE * (goal - self._amplitude)
        self._bend += EASE * (bend - self._bend)
        if self._muscles:
            self._swim(self._muscles)
        elif self._spine:
            self._phase += 1.0 / self._spine_gait(self._spine).ticks_per_beat

    def _goal(self) -> tuple[float, float]:
        """Target amplitude and bend."""
        if self.mode == "rest":
            return 0.0, 0.0
        if self._spine:
            return self._spine_gait(self._spine).amplitude, 0.0
        sides = {"left": LEFT, "right": RIGHT}
        return 1.0, sides.get(self.mode, 0.0)

    def _spine_gait(self, spine: SpinePlan) -> SpineGait:
        return {"slow": spine.slow, "fast": spine.fast}.get(self.mode, spine.medium)

    def _swim(self, muscles: Muscles) -> None:
        """Simulate a tick; restart if the body loses its shape."""
        assert self._state is not None
        grade = self.mode if self.mode in GRADES else "medium"
        swim = muscles.swim.at(grade)
        goal = np.array([*np.multiply(swim.amplitude(grade), swim.contraction), swim.lag])
        self._gait += (EASE if self._gait.any() else 1.0) * (goal - self._gait)
        front, back, lag = self._gait.tolist()
        swim = msgspec.structs.replace(swim, contraction=(front, back), lag=lag)
        per_beat = swim.ticks_per_beat * STEPS_PER_TICK
        phase = self._phase + 2 * np.pi * np.arange(STEPS_PER_TICK) / per_beat
        self._phase = float(self._phase + 2 * np.pi * STEPS_PER_TICK / per_beat) % (2 * np.pi)
        contraction = swim_contraction(swim, phase, self._amplitude)
        side = LEFT if self._bend >= 0 else RIGHT
        contraction += abs(self._bend) * bend_contraction(muscles.turn.gradual, side)
        with np.errstate(all="ignore"):
            simulate(self._body, self._state, contraction)
        self.contraction = contraction[-1]
        if not is_sound(self._state):
            self._amplitude = self._bend = 0.0
            self._begin(self._body)

    def _points(self) -> Array:
        if self._muscles:
            assert self._state is not None
            origin, rotation = body_frame(self._state.x)
            ahead = rotation[:, 0] * (1.0, 0.0, 1.0)
            self._beat.append((origin, ahead / max(float(np.linalg.norm(ahead)), 1e-9)))
            middle, axes = self._frame()
            return np.asarray((place(self._coupling, self._state.x) - middle) @ axes)
        assert self._spine
        return by_spine(self._spine, self._surface, self._phase, self._amplitude)

    def _frame(self) -> tuple[Array, Array]:
        """Origin and axes (columns ahead, up, right), averaged over the last beat."""
        origins = np.array([one for one, _ in self._beat])
        middle = origins.mean(axis=0)
        if len(origins) > 1:  # from the middle of the beat to now
            middle = middle + 0.5 * (origins[-1] - origins[0])
        ahead = np.mean([one for _, one in self._beat], axis=0)
        ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
        up = np.array([0.0, 1.0, 0.0])
        return middle, np.stack([ahead, up, np.cross(ahead, up)], axis=1)


def by_spine(plan: SpinePlan, surface: SurfacePlan, beat: float, amplitude: float) -> Array:
    """Control points (426, 3), cm, of a spine-driven fish that swims straight (KS II)."""
    rest = rest_surface(surface)
    at = np.array([beat])
    tall = along(surface.back, MIDDLES) - along(surface.belly, MIDDLES)
    heavy = along(surface.width, MIDDLES) * tall
    spine = pose_spine(plan, at, amplitude, np.zeros((1, len(MIDDLES))), heavy)
    body = rest
    if plan.wings and surface.wing:
        body = keep_height(flap_wings(plan.wings, rest, surface.wing.span, at, amplitude), rest)
    points = fit_control_points(bend_points(spine, body))[0] * plan.length
    points[:, 0] += (0.5 - plan.centre) * plan.length  # origin in the middle of the fish
    return np.asarray(points)
