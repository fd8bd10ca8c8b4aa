"""A ride on a fish: the view from between its eyes, and its retinae (Tu §6.7, §9.3)."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.base.language import marked, translated
from subsea.dive.options import RetinaColours
from subsea.frame.packet import pack
from subsea.rendering.gl.id_buffer import KINDS, IdMaps
from subsea.rendering.renderer import Renderer
from subsea.state import MENTAL_STATES
from subsea.view.camera import View
from subsea.view.follow import FollowCamera, follow_fish
from subsea.view.retina import (
    FishEyes,
    Gaze,
    bodies_at,
    eyes_pose,
    fish_eyes,
    retina_rig,
    retinal_views,
)
from subsea.view.rig import (
    CameraPose,
    CameraRig,
    DisplayPatch,
    Rect,
    front,
    limit_separation,
    seen_part,
    views,
)
from subsea.world.world import TICK_S, World

SIDES = "left", "right"
# Values of identity maps: of the first of each kind.
VALUES = {
    "water": 0, "surface": 1, "seabed": 2, "seaweed": 3, "bubbles": 4, "hook": 5,
    "pillar": 100, "rock": 300, "coral": 1000, "fish": 10000,
}  # fmt: skip
FIRST = np.array([VALUES[kind] for kind in KINDS], np.int32)
MOST_FISHES = 2**16 - VALUES["fish"]  # with values of their own in 16 bits
PLAIN = {
    "surface": (0.20, 0.24, 0.24), "seabed": (0.42, 0.38, 0.26), "seaweed": (0.16, 0.46, 0.14),
    "bubbles": (0.90, 0.90, 0.90), "hook": (0.95, 0.90, 0.20),
}  # fmt: skip
SEEN_SIZE = 48, 48  # pixels of the retinae whose brightness is measured


def retina_brightness(renderer: Renderer, world: World, by: FishEyes) -> float:
    """Mean brightness in [0, 1] of both retinae in the current tick, looking ahead (Tu §6.2).

    The mean of the two pictures as a screen shows them. It depends only on the world and the
    renderer's quality, and leaves the renderer as it was.
    """
    rig = retina_rig(SEEN_SIZE, by.half_cm)
    with renderer.apart(rig):
        renderer.draw(pack(world, retinal_views(world, by, rig, 1.0), 1.0))
        return float(np.mean([renderer.read_pixels(side) for side in range(len(SIDES))]) / 255.0)


def velocity_of(world: World, fish: int) -> tuple[float, float, float]:
    """The velocity of a fish, cm/s, in world axes."""
    x, y, z = world.state.fishes.velocity[fish].tolist()
    return x, y, z


def values_of(seen: IdMaps) -> Ints:
    """The values (h, w) of an identity map."""
    return np.asarray(FIRST[seen.kind] + seen.number)


def coded(value: Ints) -> NDArray[np.uint8]:
    """Colours (h, w, 3) of identities (h, w): fishes red, solids blue (Tu §6.7)."""
    # Successive numbers get different shades.
    shade = 0.35 + 0.65 * (value * 0.6180339887 % 1.0)
    tint = value * 0.7548776662 % 1.0
    red = np.stack([shade, 0.45 * tint * shade, 0.25 * shade], axis=-1)
    blue = np.stack([0.25 * tint * shade, 0.45 * tint * shade, shade], axis=-1)
    violet = np.stack([0.45 * shade, 0.75 * tint * shade, shade], axis=-1)
    rgb = np.zeros((*value.shape, 3))
    for name, colour in PLAIN.items():
        rgb[value == VALUES[name]] = colour
    for name, colours in (("pillar", blue), ("coral", violet), ("fish", red)):
        rgb = np.where((value >= VALUES[name])[..., None], colours, rgb)
    return np.asarray(np.rint(255.0 * rgb), np.uint8)


@cache
def codes() -> NDArray[np.uint8]:
    """The colours (65536, 3) of all values of a 16-bit map."""
    return coded(np.arange(2**16))


WIDE, ASPECT, EDGE = 0.27, 4 / 3, 0.02  # of an inset: share of the screen; its shape; its margin
STEADY_S, LEVEL_S = 0.35, 0.8  # in which the view follows the way the fish heads, and its roll
GLANCE_DEG_S = 60.0
MOST_PAN_DEG, MOST_TILT_DEG = 120.0, 70.0
LINE = np.array([[[0.0, 0.0, 0.0, 0.75]]])  # the mask of the frame round an inset: all is light
GREY_CM = 250.0  # over which what is farther gets darker by a factor e
FOR_CHILDREN = {"libido": marked("love"), "mate": marked("court")}  # on public screens


class Ride:
    """A ride on a fish: its eyes, their gaze, and the view."""

    def __init__(self, world: World, fish: int, behind: bool = False) -> None:
        """Look straight ahead through the eyes of a fish, or from `behind` it."""
        self.by = fish_eyes(world, fish)
        self.gaze = Gaze()
        self.behind = behind  # followed, rather than looked through its eyes
        self._camera: FollowCamera | None = None  # that follows it
        self._at_s = 0.0
        self._axes: Array | None = None  # forward and up, as they are followed

    def look_from(self, behind: bool) -> None:
        """Look from behind the fish, or through its eyes."""
        self.behind, self._camera, self._axes = behind, None, None

    def turn_gaze(self, right: float, up: float, dt: float) -> None:
        """Turn the gaze for `dt` seconds, at speeds in [-1, 1]."""
        pan = self.gaze.pan_deg + right * GLANCE_DEG_S * dt
        tilt = self.gaze.tilt_deg + up * GLANCE_DEG_S * dt
        self.gaze = Gaze(
            float(np.clip(pan, -MOST_PAN_DEG, MOST_PAN_DEG)),
            float(np.clip(tilt, -MOST_TILT_DEG, MOST_TILT_DEG)),
        )

    def observer(self, world: World, alpha: float) -> CameraPose:
        """The pose between the fish's eyes, with tail beat and roll damped.

        Or behind it, if it is followed; then the gaze turns the view round the fish.
        """
        if self.behind:
            aside = np.radians(self.gaze.pan_deg)
            self._camera, pose = follow_fish(world, self.by.fish, alpha, self._camera, aside)
            return pose
        now = (world.state.tick - 1 + alpha) * TICK_S
        looking = eyes_pose(world, self.by, alpha)
        axes = np.stack([looking.forward, looking.up])
        if self._axes is None or not 0.0 <= now - self._at_s < 1.0:
            self._axes = np.stack([looking.forward, [0.0, 0.0, 1.0]])  # level at first
            self._at_s = now
        share = 1.0 - np.exp(-(now - self._at_s) / np.array([STEADY_S, LEVEL_S]))
        self._axes = self._axes + share[:, None] * (axes - self._axes)
        self._at_s = now
        forward = self._axes[0] / np.linalg.norm(self._axes[0])
        up = self._axes[1] - forward * (self._axes[1] @ forward)
        if np.linalg.norm(up) < 1e-3:  # it turned upside down
            self._axes, forward, up = axes, looking.forward, looking.up
        up = up / np.linalg.norm(up)
        origin, _ = bodies_at(world, self.by.fish, alpha)
        # The head swings about the body: on its mean way it is straight ahead.
        return CameraPose(
            origin + ((looking.eye - origin) @ looking.forward) * forward, forward, up
        )

    def views(
        self, world: World, rig: CameraRig, insets: Sequence[Rect], alpha: float
    ) -> tuple[View, ...]:
        """Views of a rig on the fish, then of its eyes in the `insets`, if any.

        Through the fish's eyes, a stereo rig has at most their separation: with a larger one near
        neighbours could not be fused.
        """
        near = rig if self.behind else limit_separation(rig, self.by.half_cm)
        seen = [
            view if self.behind else replace(view, without=self.by.fish)
            for view in views(near, self.observer(world, alpha))
        ]
        if insets:
            eyes = retina_rig(insets[0][2:], self.by.half_cm, self.gaze)
            for view, inset in zip(
                views(eyes, eyes_pose(world, self.by, alpha)), insets, strict=True
            ):
                seen.append(replace(view, viewport=inset, without=self.by.fish))
        return tuple(seen)

    def text(
        self, world: World, look: RetinaColours, steered: bool = False, public: bool = False
    ) -> str:
        """Describe the fish and its mental state, or that it is steered, in one line.

        On a `public` screen in words for children.
        """
        fishes, minds, fish = world.state.fishes, world.state.minds, self.by.fish
        name = world.species[fishes.species[fish]].name

        def word(known: str) -> str:
            return translated(FOR_CHILDREN.get(known, known) if public else known)

        state = [
            f"{word(one)} {x:.0%}" for one, x in zip(MENTAL_STATES, minds.mental[fish], strict=True)
        ]
        intention = world.table.names[minds.intention[fish]]
        doing = word(marked("steered by you") if steered else intention)
        parts = [f"{translated(name)} {fish}: {doing}", *state]
        if self.gaze != Gaze():
            angles = f"{self.gaze.pan_deg:+.0f}° {self.gaze.tilt_deg:+.0f}°"
            gaze = translated("gaze")  # no word in braces gets into the catalogues
            parts.append(f"{gaze} {angles}")
        return "   ".join(parts if look == "colours" else [*parts, translated(look)])


def with_insets(rig: CameraRig) -> tuple[CameraRig, tuple[Rect, ...]]:
    """Add a picture of each eye in the upper corners of the screen ahead, for each viewer.

    Returns the rig, and where on its canvas to draw both pictures. Each lies on a slightly larger
    white patch, its frame.
    """
    ahead = front(rig)
    screen = ahead.output, ahead.channel
    wide = seen_part(ahead)[2] * ahead.squeezed[0]
    across, up = max(int(WIDE * wide), 16), max(int(WIDE * wide / ASPECT), 12)
    bottom = rig.canvas[1]
    insets = tuple((k * across, bottom, across, up) for k in range(len(SIDES)))
    patches = [
        DisplayPatch(part, inset, inset, output=patch.output, page=patch.page, mask=mask)
        for patch in rig.patches
        if (patch.output, patch.channel) == screen
        for place, inset in zip(places(patch, (across, up)), insets, strict=True)
        for part, mask in ((framed(place), LINE), (place, None))
    ]
    canvas = max(rig.canvas[0], len(SIDES) * across), bottom + up
    return rig._replace(canvas=canvas, patches=(*rig.patches, *patches)), insets


def places(patch: DisplayPatch, size: tuple[int, int]) -> tuple[Rect, Rect]:
    """The places of insets of `size` over a patch, left and right, squeezed as it is."""
    x, y, across, up = seen_part(patch)
    width, height = (round(a / b) for a, b in zip(size, patch.squeezed, strict=True))
    aside = round(EDGE * across)
    below = round(EDGE * across * patch.squeezed[0] / patch.squeezed[1])
    bottom = y + up - below - height
    return (x + aside, bottom, width, height), (x + across - aside - width, bottom, width, height)


def framed(place: Rect) -> Rect:
    """A place with its frame."""
    x, y, width, height = place
    line = max(height // 150, 1)
    return x - line, y - line, width + 2 * line, height + 2 * line


def joined(insets: Sequence[Rect]) -> Rect:
    """The part of the canvas that holds all insets, side by side."""
    left, bottom, width, height = insets[0]
    return left, bottom, len(insets) * width, height


def pasted(
    drawn: CameraRig, rig: CameraRig, picture: NDArray[np.uint8]
) -> tuple[DisplayPatch, ...]:
    """The patches of the insets in `drawn`, with sources in a picture of both eyes."""
    height, width = picture.shape[0], picture.shape[1] // len(SIDES)
    patches = []
    pictures = (patch for patch in drawn.patches[len(rig.patches) :] if patch.mask is None)
    for k, patch in enumerate(pictures):
        source: Rect = (k % len(SIDES) * width, 0, width, height)
        patches.append(patch._replace(left=source, right=source))
    return tuple(patches)


def pictured(seen: IdMaps, look: RetinaColours) -> NDArray[np.uint8]:
    """A map as colours (h, w, 3): identities, or ranges, the farther the darker."""
    if look == "identity":
        value, first = values_of(seen), VALUES["fish"]
        # Colours repeat if there are more fishes than colours.
        return np.asarray(
            codes()[np.where(value < first, value, first + (value - first) % MOST_FISHES)]
        )
    grey = np.rint(255.0 * np.exp(-seen.depth / GREY_CM)).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)


def nearest_to_middle(world: World, view: View) -> int | None:
    """The visible fish nearest to the middle of the view; if none is visible, the nearest.

    None if no fish lives but that whose view it is.
    """
    fishes = world.state.fishes
    alive = fishes.alive.copy()
    if view.without >= 0:
        alive[view.without] = False
    if not alive.any():
        return None
    way = fishes.position - np.asarray(view.eye, np.float64)
    x, y, z = view.view[:3, :3].astype(np.float64) @ way.T
    far = np.linalg.norm(way, axis=1)
    off = np.hypot(x, y) / np.maximum(-z, 1e-6)
    seen = alive & (z < 0.0) & (far < world.scenario.water.visibility_cm)
    seen &= off < np.hypot(1.0 / view.projection[0, 0], 1.0 / view.projection[1, 1])
    if seen.any():
        return int(np.argmin(np.where(seen, off, np.inf)))
    return int(np.argmin(np.where(alive, far, np.inf)))
