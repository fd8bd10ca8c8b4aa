"""A preview of one fish in clear water and even light, seen from an orbit about it.

Uses the shaders of the sea. Control points may change with every picture, the shape and the skin
with every edit.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from msgspec import structs

from subsea.base.arrays import Array, Bytes
from subsea.fish.species import Species, Variation
from subsea.fish.surface import CONTROL_POINTS, rest_surface
from subsea.frame.packet import (
    DISPLAY,
    IDENTITY,
    INSTANCE_COLUMNS,
    Batch,
    Packet,
    RenderScene,
)
from subsea.frame.packet import FINS as FIN_COLUMNS
from subsea.rendering.fish.fishes import FishRenderer
from subsea.rendering.gl.context import GpuOwner
from subsea.rendering.gl.shaders import TEXTURE_UNITS
from subsea.rendering.gl.textures import mipmapped
from subsea.rendering.output.quality import Quality
from subsea.rendering.output.target import RenderTarget, ResolvePass
from subsea.rendering.output.uniforms import uniforms_of
from subsea.scenario.schema import Water
from subsea.state import FINS_AT_EASE
from subsea.view.camera import View, look, off_axis
from subsea.view.display_rigs import display_rig

BACKDROP = (0.012, 0.048, 0.068)  # linear light
WATER = Water(fog=(0.03, 0.10, 0.14), visibility_cm=1e5)  # for silver to mirror
HALF_FIELD = 0.16  # tangent of half the angle of view across: little perspective
ROOM = 1.16  # size of the picture over that of the fish
LEAST_TALL = 0.3  # least height of the picture, body lengths
NEAREST, FARTHEST = 0.25, 8.0  # of the zoom
STEEPEST = np.radians(89.0)
ALIKE = Variation(hue=0.0, saturation=0.0, brightness=0.0, pattern=0.0, torn=0.0, scarred=0.0)
UPRIGHT = np.sqrt([0.5, 0.5, 0.0, 0.0])  # body to world: heading along x, back up
DRAWN_CM = 20.0  # length as drawn, so that all fishes have the same light
DEPTH_CM = 450.0  # for daylight as in the scenarios
FINS = (0.5, 0.55, *FINS_AT_EASE[2:])  # as `frame.packet.FINS`
SAMPLES = 4
CLOSE_UP = Quality(close_up=True)
LEVEL_CAUSTICS = 1 / 1.85  # light without waves, in the scale of `optics.glsl`


@dataclass(frozen=True)
class Orbit:
    """Position of the eye about the fish, which heads left at `turn` 0."""

    turn: float = 0.0  # rad, about the vertical; a quarter turn shows its face
    tilt: float = 0.0  # rad, up
    zoom: float = 1.0  # 1: the fish fits

    def moved(self, turn: float, tilt: float) -> "Orbit":
        """Turned by `turn` and `tilt` rad, with the tilt limited."""
        return replace(
            self,
            turn=(self.turn + turn) % (2 * np.pi),
            tilt=float(np.clip(self.tilt + tilt, -STEEPEST, STEEPEST)),
        )

    def zoomed(self, times: float) -> "Orbit":
        """Enlarged, within limits."""
        return replace(self, zoom=float(np.clip(self.zoom * times, NEAREST, FARTHEST)))


class FishPreview(GpuOwner):
    """A fish on the GPU, and the texture that it is drawn into."""

    def __init__(self, context: Any, species: Species, sheet: Bytes) -> None:
        """Upload a fish with a skin `sheet`, as `fish.paint` makes it."""
        super().__init__()
        self._context = context
        self._measure(species)
        plain = without_variation(species)
        scene = RenderScene(
            species=(plain,),
            control_points=np.zeros((1, CONTROL_POINTS, 3), np.float32),
            recorded_length_cm=(species.length_cm,),
            terrain=np.zeros((2, 2), np.float32),
            terrain_half_width_cm=1.0,
            water=WATER,
        )
        self._fishes = self.own(FishRenderer(context, scene, [sheet], CLOSE_UP))
        even = np.full((1, 1, 2), LEVEL_CAUSTICS, np.float16)
        self._light = self.own(mipmapped(context, even))
        self._resolve: ResolvePass | None = None
        self._sized = self.own(GpuOwner())
        self.size = (0, 0)
        self.texture: Any = None  # the picture, bottom row first

    def update(self, species: Species, sheet: Bytes | None = None) -> None:
        """Replace the shape, and the skin sheet if given."""
        self._measure(species)
        self._fishes.update(
            (without_variation(species),), (species.length_cm,), None if sheet is None else [sheet]
        )

    def draw(
        self,
        points: Array,
        orbit: Orbit = Orbit(),
        size: tuple[int, int] = (640, 360),
        fins: tuple[float, ...] = FINS,
        courting: float = 0.0,
    ) -> Any:
        """Draw control points (426, 3), cm in body axes; returns the texture of `size` pixels.

        `fins` are as in an instance (`frame.packet.FINS`), `courting` is the share of mating
        colours. The texture stays the same while `size` does.
        """
        if size != self.size:
            self._resize(size)
        context = self._context
        view = self._view(orbit, size)
        record = np.zeros((1, INSTANCE_COLUMNS), np.float32)
        record[0, 2:8] = -DEPTH_CM, self._scale, *UPRIGHT
        record[0, IDENTITY], record[0, FIN_COLUMNS], record[0, DISPLAY] = 0.5, fins, courting
        batches = ((Batch(0, 0, 1),),)
        packet = Packet(
            0.0, (view,), record, batches, np.zeros((0, 3), np.float32), 0,
            live_points=np.asarray(points, np.float32)[None],
        )  # fmt: skip
        self._fishes.upload(packet)
        framebuffer = self._target.framebuffer
        framebuffer.use()
        context.viewport = (0, 0, *size)
        context.scissor = None
        framebuffer.clear(*BACKDROP)
        context.enable(context.DEPTH_TEST | context.BLEND)
        context.disable(context.CULL_FACE)
        context.depth_func = "<="
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA
        self._light.use(TEXTURE_UNITS["u_caustics"])
        uniforms = uniforms_of(packet, view, WATER) | {"u_close_up": True}
        self._fishes.draw(packet, 0, uniforms)
        assert self._resolve
        self._resolve.draw(self._target.resolved(), self._target.framebuffers[0, 0], size, 0)
        context.detect_framebuffer(0).use()
        return self.texture

    def read_pixels(self) -> Bytes:
        """The last picture (h, w, 3), top row first."""
        data = self._target.framebuffers[0, 0].read(components=3, alignment=1)
        return np.frombuffer(data, np.uint8).reshape(*self.size[::-1], 3)[::-1]

    def _view(self, orbit: Orbit, size: tuple[int, int]) -> View:
        across = ROOM * DRAWN_CM * max(1.0, self._tall * size[0] / size[1]) / orbit.zoom
        away = across / 2 / HALF_FIELD
        toward = np.array(
            [
                np.cos(orbit.tilt) * np.sin(orbit.turn),
                np.cos(orbit.tilt) * np.cos(orbit.turn),
                np.sin(orbit.tilt),
            ]
        )
        middle = self._scale * self.middle[[0, 2, 1]] * (1, -1, 1) + (0, 0, -DEPTH_CM)
        eye = middle + away * toward
        near = 0.05 * away
        half = near * HALF_FIELD * np.array([1.0, size[1] / size[0]])
        projection = off_axis(-half[0], half[0], -half[1], half[1], near, 4.0 * away)
        return View((0, 0, *size), look(eye, -toward, np.array([0, 0, 1.0])), projection, eye)

    @property
    def _scale(self) -> float:
        return DRAWN_CM / self._species.length_cm

    def _measure(self, species: Species) -> None:
        """Measure height or width with fins, and the point that the eye looks at."""
        surface, length = species.surface, species.length_cm
        points = rest_surface(surface)
        low, high = float(points[:, 1].min()), float(points[:, 1].max())
        for fin in (surface.pectoral, surface.pelvic):
            if fin:
                tip = fin.height - fin.length * np.sin(np.radians(fin.droop))
                low, high = min(low, tip - fin.width / 2), max(high, tip + fin.width / 2)
        snout = species.body.stations[2] if species.body else 0.5 * length
        self._species = species
        self._tall = max(high - low, 2 * float(points[:, 2].max()), LEAST_TALL)
        self.middle = np.array([snout - 0.5 * length, length * (low + high) / 2, 0.0])  # body axes

    def _resize(self, size: tuple[int, int]) -> None:
        self._sized.release()
        samples = min(SAMPLES, self._context.max_samples)
        self._target = self._sized.own(RenderTarget(self._context, size, samples, [size]))
        self.texture = self._target.pictures[0, 0]
        patches = display_rig("mono", size).patches
        if self._resolve is None:
            self._resolve = self.own(ResolvePass(self._context, patches))
        else:
            self._resolve.arrange(patches)
        self.size = size


def without_variation(species: Species) -> Species:
    """Return the species without individual variation of its skin."""
    return structs.replace(species, skin=structs.replace(species.skin, variation=ALIKE))
