"""A sea to step from a program; pictures of it, and retinae of its fishes, as arrays."""

import threading
import weakref
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.base.errors import unknown
from subsea.base.progress import say
from subsea.base.toml_edit import toml_value
from subsea.behavior.intention import Behavior, Routine
from subsea.behavior.teleop import TeleopCommand, TeleopCommands
from subsea.dive.ride import values_of
from subsea.dive.warm_up import warm_up
from subsea.frame.packet import make_scene, pack
from subsea.rendering.gl.context import headless_context
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.repertoire import SEGMENTS
from subsea.scenario.load import LoadedScenario, load_scenario
from subsea.state import (
    COURTSHIP,
    HUNT,
    KINDS,
    MENTAL_STATES,
    ODOURS,
    Fishes,
    Minds,
    Sea,
    Submarine,
)
from subsea.submarine.vessel import NEUTRAL, Helm
from subsea.view.display_rigs import cockpit, display_rig
from subsea.view.follow import follow_fish
from subsea.view.retina import FIELD_DEG, OPENCV, Gaze, fish_eyes, retina_rig, retinal_views
from subsea.view.rig import CameraPose, CameraRig, pose_from_angles, views
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import Order, step
from subsea.world.world import TICK_S
from subsea.world.world import World as State

G = TypeVar("G", bound=tuple[Any, ...])
Changes = Mapping[str, Any] | Iterable[str]


MOST_SEED, MOST_FISHES = 2**32 - 1, 100_000  # as of the options of commands


def load(
    scenario: str,
    *,
    seed: int | None = None,
    fish: int | None = None,
    changes: Changes = (),
    behaviors: Sequence[Behavior] = (),
    senses: Sequence[Routine] = (),
) -> "World":
    """Load a scenario as a world at tick 0.

    Args:
        scenario: A name of `subsea.scenarios()`, or the path of a file.
        seed: The seed of all random numbers; None: the scenario's.
        fish: The number of fishes to which its shoals are scaled; None: the scenario's.
        changes: Values that replace the scenario's, by key: `{"nature.keen": 0.4}`, or texts as
            `--set` takes them. docs/reference/scenario-keys.md lists the keys.
        behaviors: Rules of your own, as of `subsea.rule`: each replaces the behavior of its name,
            or adds one.
        senses: Senses of your own, as of `subsea.sense`, which come after those of a fish.

    Raises:
        UserError: An unknown scenario or key, a value outside its range, or a rule that replaces
            no behavior and has no desire.
        ValueError: A seed outside 0 to 4294967295, or a number of fishes outside 1 to 100000.

    The first call after an installation compiles the kernels, which takes a minute.

    Examples:
        >>> world = subsea.load("peaceful", seed=1, fish=10)
        >>> world
        World('peaceful', seed=1, 10 fishes, tick 0)
    """
    check_numbers(seed, fish)
    check_rules(behaviors, senses)
    loaded = load_scenario(scenario, change_texts(changes))
    warm_up(say)
    source = str(loaded.path)
    state = create_world(loaded.scenario, seed, fish, source=source, behaviors=behaviors)
    state.senses = tuple(senses)
    return World(state, scenario, loaded)


def check_rules(behaviors: Sequence[Behavior], senses: Sequence[Routine]) -> None:
    """Raise a TypeError for rules that are not made by `subsea.rule` or `subsea.sense`."""
    for one in behaviors:
        if not isinstance(one, Behavior):
            raise TypeError(
                f"behaviors: expected what subsea.rule('school', function) returns, got {one!r}"
            )
    for sense in senses:
        if not callable(sense):
            raise TypeError(
                f"senses: expected what subsea.sense('light', function) returns, got {sense!r}"
            )


def check_numbers(seed: int | None, fish: int | None) -> None:
    """Raise a ValueError for a seed or a number of fishes that no command accepts."""
    for name, value, least, most in (
        ("seed", seed, 0, MOST_SEED), ("fish", fish, 1, MOST_FISHES)
    ):  # fmt: skip
        whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if value is not None and not (whole and least <= value <= most):
            raise ValueError(f"{name}: {value!r}, expected a whole number from {least} to {most}")


def change_texts(changes: Changes) -> list[str]:
    """Changes of a scenario as `--set` takes them."""
    if isinstance(changes, str):
        raise TypeError(f"changes: expected a mapping or a list of texts, got {changes!r}")
    if not isinstance(changes, Mapping):
        return [*changes]
    return [f"{key}={_toml(value)}" for key, value in changes.items()]


def _toml(value: Any) -> str:
    return toml_value(value.tolist() if isinstance(value, np.ndarray | np.generic) else value)


class World:
    """A sea with its fishes and the submarine; `subsea.load` makes one.

    The arrays of `fishes`, `minds`, `sea` and `submarine` show the current tick. They cannot be
    written, and change with each step: copy what is to be kept. Row k of the fishes' and the minds'
    arrays is fish k. Lengths are in cm, times in s, angles in rad; z points up and the surface of
    the sea is at 0. docs/reference/state.md lists every array with its shape, type and unit.

    Examples:
        >>> world = subsea.load("peaceful", seed=1, fish=10)
        >>> world.step(30)
        >>> world.tick, world.fishes.position.shape
        (30, (10, 3))
        >>> world.fishes.position[0] = 0.0
        Traceback (most recent call last):
        ValueError: assignment destination is read-only
    """

    def __init__(
        self, state: State, scenario: str = "", loaded: LoadedScenario | None = None
    ) -> None:
        """Wrap a world of `subsea.world.build.create_world`; `loaded` is what it was made of."""
        self.internal = state  # for what this class does not offer; may change at any time
        self.scenario = scenario
        self.loaded = loaded
        parts = state.state
        self._fishes = _read_only(parts.fishes)
        self._minds = _read_only(parts.minds)
        self._sea = _read_only(parts.sea)
        self._submarine = Submarine(
            **{name: _view(array) for name, array in vars(parts.submarine).items()}
        )

    @property
    def fishes(self) -> Fishes:
        """Bodies of the n fishes: position (n, 3) cm, velocity (n, 3) cm/s, alive (n,) …"""
        return self._fishes

    @property
    def minds(self) -> Minds:
        """Minds of the n fishes: mental (n, 3) in [0, 1], intention (n,), leader (n,) …"""
        return self._minds

    @property
    def sea(self) -> Sea:
        """Surroundings: plankton (p, 3) cm, rocks (k, 7), heights of the seabed (m, m) cm …"""
        return self._sea

    @property
    def submarine(self) -> Submarine:
        """The hull: position (3,) cm, velocity (3,) cm/s, heading and pitch (2,) rad …"""
        return self._submarine

    @property
    def tick(self) -> int:
        """Number of ticks since the start; one is 0.033 s."""
        return self.internal.state.tick

    @property
    def time_s(self) -> float:
        """Time since the start, s."""
        return self.tick * TICK_S

    @property
    def seed(self) -> int:
        """The seed of all random numbers."""
        return self.internal.state.seed

    @property
    def species(self) -> tuple[str, ...]:
        """The common names to which `fishes.species` points."""
        return tuple(one.name for one in self.internal.species)

    @property
    def names(self) -> dict[str, tuple[str, ...]]:
        """The names of codes and columns, by the array that holds them.

        Examples:
            >>> world = subsea.load("peaceful", seed=1, fish=10)
            >>> world.names["minds.mental"]
            ('hunger', 'libido', 'fear')
        """
        return {
            "fishes.species": self.species,
            "fishes.segment": tuple(SEGMENTS),
            "minds.intention": self.internal.table.names,
            "minds.mental": tuple(MENTAL_STATES),
            "minds.kind": tuple(KINDS),
            "minds.courtship": tuple(COURTSHIP),
            "minds.hunt": tuple(HUNT),
            "minds.scent": tuple(ODOURS),
        }

    def step(self, n: int = 1, order: Order = NEUTRAL) -> None:
        """Advance by `n` ticks of 0.033 s.

        Args:
            n: Number of ticks, at least 0.
            order: A `subsea.Helm` steers the submarine. A `subsea.TeleopCommand` steers a fish in
                place of its mind, `subsea.TeleopCommands` several, while the submarine holds its
                place.

        Raises:
            ValueError: A number of ticks that is negative or not whole, a value outside [-1, 1],
                an unknown fish.
            UserError: A rule of your own that fails; the world is in the middle of a tick then.

        The same scenario, seed and orders give the same world bit for bit.
        """
        if not isinstance(n, int | np.integer) or isinstance(n, bool) or n < 0:
            raise ValueError(f"n: {n!r}, expected a whole number of ticks of at least 0")
        checked = self.checked(order)
        for _ in range(n):
            step(self.internal, checked)

    def snapshot(self) -> bytes:
        """Everything that a tick may change, for `restore`."""
        return snapshot.take(self.internal)

    def restore(self, data: bytes) -> None:
        """Return to a snapshot of a world of the same scenario and seed.

        Raises:
            UserError: A snapshot of another world, or a damaged one; this world is unchanged then.

        Examples:
            >>> world = subsea.load("peaceful", seed=1, fish=10)
            >>> before, kept = world.checksum(), world.snapshot()
            >>> world.step(5)
            >>> world.restore(kept)
            >>> world.checksum() == before
            True
        """
        snapshot.restore(self.internal, data)

    def checksum(self) -> str:
        """A checksum of everything that changes: equal checksums mean equal worlds."""
        return snapshot.checksum(self.internal)

    def __repr__(self) -> str:
        """Its scenario, seed, number of fishes and tick."""
        n = len(self.fishes.species)
        return f"World({self.scenario!r}, seed={self.seed}, {n} fishes, tick {self.tick})"

    def checked(self, order: Any) -> Order:
        """Return an order with values that compiled code may take; a ValueError or TypeError."""
        if not isinstance(order, Helm | TeleopCommand | TeleopCommands):
            raise TypeError(
                f"order: expected a Helm, a TeleopCommand or TeleopCommands, got {order!r}"
            )
        given = {name: np.asarray(value) for name, value in order._asdict().items()}
        many = isinstance(order, TeleopCommands)
        for name, values in given.items():
            if values.shape != (given["fish"].shape if many else ()):
                expected = f"one number{' for each fish' * many}"
                raise ValueError(f"order: {name} has shape {values.shape}, expected {expected}")
            if name == "fish":
                for fish in values.ravel():
                    check_fish(self, fish)
            elif values.dtype.kind not in "fiub" or not (np.abs(values) <= 1).all():
                raise ValueError(
                    f"order: {name} {order._asdict()[name]!r}, expected numbers from -1 to 1"
                )
        if not many:
            return order
        if len(set(given["fish"].tolist())) < given["fish"].size:
            raise ValueError("order: a fish is there twice")
        kinds = (np.int64, np.float64, np.float64, np.float64, np.bool_)
        return TeleopCommands(
            *(one.astype(kind) for one, kind in zip(given.values(), kinds, strict=True))
        )


def check_fish(world: World, fish: int) -> None:
    """Raise a ValueError if a world has no such fish."""
    n = len(world.fishes.species)
    if not isinstance(fish, int | np.integer) or not 0 <= fish < n:
        raise ValueError(f"fish {fish}: expected one from 0 to {n - 1}")


def _read_only(group: G) -> G:
    """A group of the state whose arrays cannot be written."""
    members = (_view(one) if isinstance(one, np.ndarray) else one for one in group)
    return type(group)(*members)


def _view(array: Any) -> Any:
    """A view of an array that cannot be written."""
    view = array.view()
    view.flags.writeable = False
    return view


MOST_PIXELS = 8192  # of a side

_lock = threading.RLock()  # an OpenGL context is current in one thread at a time
_renderers: "weakref.WeakKeyDictionary[World, Renderer]" = weakref.WeakKeyDictionary()


class Retina(NamedTuple):
    """The pictures in both eyes of a fish, the left one first, top row first (Tu §6.7).

    Each is a flat perspective picture of 90° from left to right, so its focal length is f = w/2
    pixels in both directions, and its middle is at ((w − 1)/2, (h − 1)/2), with the middle of the
    upper left pixel at (0, 0). A point (x, y, z) in the axes of an eye is at the pixel
    (f x/z + (w − 1)/2, f y/z + (h − 1)/2).
    """

    picture: NDArray[np.uint8]  # (2, h, w, 3) red, green, blue
    identity: Ints  # (2, h, w) what each pixel shows: docs/how-to/fish-frames.md
    depth: Array  # (2, h, w) cm along the optical axis, infinite in open water
    matrices: Array  # (2, 4, 4) from the world, cm, to the axes of each eye: right, down, ahead


def camera(
    eye: Any,
    target: Any = None,
    up: Any = (0.0, 0.0, 1.0),
    *,
    angles: tuple[float, float] | None = None,
) -> CameraPose:
    """A camera at `eye` (3,) that looks at `target` (3,), both in cm.

    Or one with `angles` in degrees instead of a target: from +x to the left, and upward.

    Raises:
        ValueError: Points other than three finite numbers, a view along `up`, or not one of target
            and angles.

    Examples:
        >>> subsea.camera((0, 0, -200), (300, 0, -200)).forward
        array([1., 0., 0.])
        >>> subsea.camera((0, 0, -200), angles=(90, 0)).forward.round(6)
        array([0., 1., 0.])
    """
    if (target is None) == (angles is None):
        raise ValueError("camera: expected either a target or angles")
    if angles is not None:
        given = np.radians(_vector("angles", (*angles, 0.0)))
        return pose_from_angles(_vector("eye", eye), float(given[0]), float(given[1]))
    place, to, above = (_vector(*named) for named in (("eye", eye), ("target", target), ("up", up)))
    side = np.cross(to - place, above)
    if not side.any():
        raise ValueError("camera: the target lies at the eye or along `up`")
    forward = (to - place) / np.linalg.norm(to - place)
    right = side / np.linalg.norm(side)
    return CameraPose(place, forward, np.cross(right, forward))


def behind(world: World, fish: int) -> CameraPose:
    """A camera behind and above a fish, clear of stone and sand.

    Raises:
        ValueError: An unknown fish.
    """
    check_fish(world, fish)
    return follow_fish(world.internal, fish, 1.0, None)[1]


def render(
    world: World,
    camera: CameraPose | None = None,
    size: tuple[int, int] = (640, 360),
    quality: str = "medium",
) -> NDArray[np.uint8]:
    """Draw a world without a window.

    Args:
        world: The world at its current tick, which drawing does not change.
        camera: The view, as of `subsea.camera` or `subsea.behind`; None: the pilot's.
        size: Width and height, pixels.
        quality: "low", "medium" or "high".

    Returns:
        The picture (h, w, 3), top row first. It is a flat perspective picture of 55° from top to
        bottom, so its focal length is 0.96 h pixels in both directions.

    Raises:
        UserError: No OpenGL 3.3, or an unknown quality.
        ValueError: A size that is not two numbers from 1 to 8192.

    The first picture of a world takes some seconds, as its scenery is uploaded.
    """
    rig = display_rig("mono", checked_size(size))
    with drawing(world, rig, quality) as renderer:
        state = world.internal
        pose = cockpit(state.state.submarine, 1.0) if camera is None else camera
        renderer.draw(pack(state, views(rig, pose), 1.0, options=renderer.quality.packing))
        return renderer.read_pixels()


def retina(
    world: World,
    fish: int,
    size: tuple[int, int] = (64, 64),
    gaze: tuple[float, float] = (0.0, 0.0),
    quality: str = "low",
) -> Retina:
    """Draw what a fish sees with both eyes.

    Args:
        world: The world at its current tick.
        fish: Index of the fish.
        size: Width and height of the picture of one eye, pixels.
        gaze: Pan to its right and tilt toward its back, degrees. Both eyes look along the body
            without it.
        quality: "low", "medium" or "high".

    Raises:
        UserError: No OpenGL 3.3, or an unknown quality.
        ValueError: An unknown fish, or a size that is not two numbers from 1 to 8192.
    """
    check_fish(world, fish)
    state = world.internal
    by = fish_eyes(state, fish)
    rig = retina_rig(checked_size(size), by.half_cm, Gaze(*gaze), FIELD_DEG)
    with drawing(world, rig, quality) as renderer:
        seeing = retinal_views(state, by, rig, 1.0)
        packet = pack(state, seeing, 1.0, options=renderer.quality.packing)
        renderer.draw(packet)
        pictures = [renderer.read_pixels(side) for side in range(2)]
        seen = renderer.id_maps(packet)
    values, depth = (np.stack(np.split(one, 2, axis=1)) for one in (values_of(seen), seen.depth))
    matrices = np.stack([OPENCV @ view.view.astype(np.float64) for view in seeing])
    return Retina(np.stack(pictures), values, depth, matrices)


@cache
def _context() -> Any:
    """The context of all pictures of this process."""
    return headless_context()


@contextmanager
def drawing(world: World, rig: CameraRig, quality: str) -> Iterator[Renderer]:
    """Yield the renderer of a world, with its context current in this thread."""
    if quality not in PRESETS:
        raise unknown("quality", quality, list(PRESETS))
    with _lock, _context():
        renderer = _renderers.get(world)
        if renderer is None:
            scene = make_scene(world.internal)
            renderer = _renderers[world] = Renderer(_context(), scene, rig, PRESETS[quality])
            weakref.finalize(world, _release, renderer).atexit = False
        if renderer.quality != PRESETS[quality]:
            renderer.adapt(PRESETS[quality])
        with renderer.apart(rig):  # else levels of detail would depend on earlier pictures
            yield renderer


def _release(renderer: Renderer) -> None:
    """Free the GPU objects of a world that is gone."""
    with _lock, _context():
        renderer.release()


def checked_size(size: tuple[int, int]) -> tuple[int, int]:
    """A size in pixels; a ValueError for anything else."""
    given = np.asarray(size)
    numbers = given.shape == (2,) and given.dtype.kind in "iu"
    if not numbers or (given < 1).any() or (given > MOST_PIXELS).any():
        raise ValueError(f"size: expected width and height from 1 to {MOST_PIXELS}, got {size!r}")
    width, height = given.tolist()
    return width, height


def _vector(name: str, value: Any) -> Array:
    """Three finite numbers; a ValueError for anything else."""
    try:
        given = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        given = np.zeros(0)
    if given.shape != (3,) or not np.isfinite(given).all():
        raise ValueError(f"camera: {name} {value!r}, expected three finite numbers")
    return given
