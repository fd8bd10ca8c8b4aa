"""Pictures of a world, and the retinae of its fishes, as arrays."""

import threading
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.base.errors import unknown
from subsea.dive.retina_images import values_of
from subsea.frame.packet import make_scene, pack
from subsea.library.world import World, check_fish
from subsea.rendering.gl.context import headless_context
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.view.display_rigs import cockpit, display_rig
from subsea.view.follow import follow_fish
from subsea.view.retina import FIELD_DEG, Gaze, fish_eyes, retina_rig, retinal_views
from subsea.view.rig import CameraPose, CameraRig, views

MOST_PIXELS = 8192  # of a side

_lock = threading.RLock()  # an OpenGL context is current in one thread at a time
_renderers: "weakref.WeakKeyDictionary[World, Renderer]" = weakref.WeakKeyDictionary()


class Retina(NamedTuple):
    """The pictures in both eyes of a fish, the left one first, top row first (Tu §6.7)."""

    picture: NDArray[np.uint8]  # (2, h, w, 3) red, green, blue
    identity: Ints  # (2, h, w) what each pixel shows: docs/how-to/fish-frames.md
    depth: Array  # (2, h, w) cm along the optical axis, infinite in open water


def camera(eye: Any, target: Any, up: Any = (0.0, 0.0, 1.0)) -> CameraPose:
    """A camera at `eye` (3,) that looks at `target` (3,), both in cm.

    Raises:
        ValueError: Points other than three finite numbers, or a view along `up`.

    Examples:
        >>> subsea.camera((0, 0, -200), (300, 0, -200)).forward
        array([1., 0., 0.])
    """
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
        The picture (h, w, 3), top row first.

    Raises:
        UserError: No OpenGL 3.3, or an unknown quality.
        ValueError: A size that is not two numbers from 1 to 8192.

    The first picture of a world takes some seconds, as its scenery is uploaded.
    """
    rig = display_rig("mono", _checked(size))
    with _drawing(world, rig, quality) as renderer:
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
        gaze: Pan to its right and tilt toward its back, degrees.
        quality: "low", "medium" or "high".

    Raises:
        UserError: No OpenGL 3.3, or an unknown quality.
        ValueError: An unknown fish, or a size that is not two numbers from 1 to 8192.
    """
    check_fish(world, fish)
    state = world.internal
    by = fish_eyes(state, fish)
    rig = retina_rig(_checked(size), by.half_cm, Gaze(*gaze), FIELD_DEG)
    with _drawing(world, rig, quality) as renderer:
        packet = pack(
            state, retinal_views(state, by, rig, 1.0), 1.0, options=renderer.quality.packing
        )
        renderer.draw(packet)
        pictures = [renderer.read_pixels(side) for side in range(2)]
        seen = renderer.id_maps(packet)
    values, depth = (np.stack(np.split(one, 2, axis=1)) for one in (values_of(seen), seen.depth))
    return Retina(np.stack(pictures), values, depth)


@cache
def _context() -> Any:
    """The context of all pictures of this process."""
    return headless_context()


@contextmanager
def _drawing(world: World, rig: CameraRig, quality: str) -> Iterator[Renderer]:
    """The renderer of a world, with its context current in this thread."""
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


def _checked(size: tuple[int, int]) -> tuple[int, int]:
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
