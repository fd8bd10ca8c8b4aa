"""Draws a picture: rocks, reef, seabed, water, fishes, particles; then tone mapping."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import moderngl
import numpy as np

from subsea.base.arrays import Array, Bytes
from subsea.base.disk_cache import cached
from subsea.base.errors import UserError
from subsea.frame.packet import Packet, RenderScene
from subsea.rendering.fish.fishes import FishRenderer
from subsea.rendering.fish.soft_shadows import SoftShadowRenderer
from subsea.rendering.gl.context import GpuOwner, GpuTimer
from subsea.rendering.gl.id_buffer import IdBuffer, IdMaps
from subsea.rendering.gl.shaders import TEXTURE_UNITS
from subsea.rendering.gl.static_batch import LazyMesh, StaticMesh, box_around
from subsea.rendering.gl.textures import near_and_far, noise, repeating, upload
from subsea.rendering.output.exposure import ExposureSum
from subsea.rendering.output.marks import MarkRenderer
from subsea.rendering.output.overlay import OverlayRenderer
from subsea.rendering.output.passes import LightParts, PartsTarget
from subsea.rendering.output.quality import PRESETS, Quality
from subsea.rendering.output.target import OWN, Into, RenderTarget, ResolvePass, scaled
from subsea.rendering.output.uniforms import uniforms_of, water_of
from subsea.rendering.output.vessel import TheatreVesselRenderer
from subsea.rendering.reef import coral, rocks
from subsea.rendering.reef.coral import CoralRenderer, bake, spheres
from subsea.rendering.reef.rocks import RockRenderer, overgrown
from subsea.rendering.reef.seaweed import SeaweedRenderer
from subsea.rendering.sea.ground_map import GroundMap
from subsea.rendering.sea.hook import HookRenderer
from subsea.rendering.sea.particles import BubbleRenderer, LineRenderer, ParticleRenderer
from subsea.rendering.sea.seabed import SeabedRenderer, surroundings
from subsea.rendering.sea.sunlight import LightShaftRenderer, SunShadows
from subsea.rendering.sea.water import WaterRenderer
from subsea.scenario.schema import Grade
from subsea.view.camera import View, middle_eye
from subsea.view.culling import IN_SIGHT
from subsea.view.rig import CameraRig, DisplayPatch, Projection, Rect, tile

NO_MARKS: Mapping[int, Array] = {}


class BakedScene(NamedTuple):
    """The slow parts of a scene for a renderer that need no OpenGL: they take seconds to make."""

    stone: "Future[list[list[StaticMesh]]]"
    ground: "Future[GroundMap]"
    growths: "Future[list[list[LazyMesh]]]"
    balls: "Future[Array]"  # `reef.coral.spheres`


def bake_scene(scene: RenderScene) -> BakedScene:
    """Compute it in a thread while another scene is drawn, which needs most of the time."""
    with ThreadPoolExecutor(1) as pool:
        return _baking(scene, pool)


def _baking(scene: RenderScene, pool: ThreadPoolExecutor) -> BakedScene:
    """Begin in the threads of a pool. numpy and compiled kernels release the GIL."""
    bed = scene.terrain, scene.terrain_half_width_cm
    solids = *bed, scene.pillars, scene.rocks, scene.water.hour
    moving = (True,) if scene.water.day_minutes else ()

    def balls() -> Array:
        growths.result()  # first: both read the same forms
        return cached(spheres, scene.reef)

    growths = pool.submit(bake, scene.reef)
    return BakedScene(
        pool.submit(lambda: cached(overgrown, *solids, scene.reef, *moving)),
        pool.submit(lambda: cached(surroundings, *solids, scene.reef, *moving)),
        growths,
        pool.submit(balls),
    )


class Renderer(GpuOwner):
    """Draws the packets of one scene; owns all GPU objects."""

    rig: CameraRig

    def __init__(
        self,
        context: Any,
        scene: RenderScene,
        rig: CameraRig,
        quality: Quality = PRESETS["medium"],
        page: Callable[[int], object] = lambda number: None,
        check: Callable[[], object] = lambda: None,
        baked: BakedScene | None = None,
        fishes: FishRenderer | None = None,
    ) -> None:
        """Upload a scene for packets whose views are those of `rig`.

        `page(0)` and `page(1)` select the left and right buffer of a window that has two. `check`
        is called between steps, and may raise to stop. `baked` is `bake_scene` of the scene, if
        there was time before. `fishes` are those of another renderer (`give_fishes`), used again
        if the scene has the same.
        """
        super().__init__()
        self._context = context
        self._page = page
        self._scene = scene
        self.quality = quality
        self.wireframe = False  # draw the edges of triangles, except for the water
        self.bodies = True  # False: fishes are neither drawn nor cast shadows
        self.triangles = 0  # of the last picture
        self.draw_calls = 0  # of the last picture
        self.draw_s = 0.0  # of the last picture: until its drawing calls returned
        self.upload_s = 0.0  # of the last picture: copying the packet to the GPU
        self.waited_s = 0.0  # by the last picture, for the one before
        self.gpu_s = 0.0  # of the picture before the last: time of the GPU, 0 if unknown
        self.timer = GpuTimer(context)
        # Beside the calls of OpenGL.
        with ThreadPoolExecutor() as pool:
            stone, ground, growths, balls = baked or _baking(scene, pool)
            self._caustics = self.own(repeating(context, near_and_far, 1))
            self._noise = self.own(repeating(context, noise, 2))
            self._shafts = self.own(LightShaftRenderer(context, quality))
            check()
            self._water = self.own(WaterRenderer(context, scene, quality))
            check()
            self._seabed = self.own(SeabedRenderer(context, scene, ground.result(), quality))
            check()
            self._rocks = self.own(RockRenderer(context, scene, stone.result(), quality))
            self._shadows = self.own(SoftShadowRenderer(context, scene))
            check()
            reach_cm = IN_SIGHT * scene.water.visibility_cm
            self._coral = self.own(
                CoralRenderer(
                    context, scene.reef, growths.result(), balls.result(), reach_cm, quality
                )
            )
            self._seaweed = self.own(SeaweedRenderer(context, quality))
            check()
            if fishes is not None and not fishes.fits(scene):
                fishes.release()
                fishes = None
            self._fishes = self.own(fishes or FishRenderer(context, scene, quality=quality))
        box = box_around([self._rocks, self._coral])
        self._sun = self.own(SunShadows(context, scene.water.hour, box))
        self._hook = self.own(HookRenderer(context, quality))
        check()
        self._bubbles = self.own(BubbleRenderer(context, scene, quality))
        self._particles = self.own(ParticleRenderer(context, scene, quality))
        self._lines = self.own(LineRenderer(context))
        self._resolve = self.own(ResolvePass(context, rig.patches, quality.smooth, scene.grade))
        self.vessel = self.own(TheatreVesselRenderer(context))
        self.overlay = self.own(OverlayRenderer(context))
        self._sized = self.own(GpuOwner())  # released when the size changes
        # Made when first needed.
        self._ids: IdBuffer | None = None
        self._parts: PartsTarget | None = None
        self._exposure: ExposureSum | None = None
        self._shaded: dict[str, Any] = {}  # uniforms of the shadows of the last picture
        self._overlay: ResolvePass | None = None
        self._second: ResolvePass | None = None
        self._marks: MarkRenderer | None = None
        self._make_target(rig, quality)
        self.adapt(quality)

    def give_fishes(self) -> FishRenderer:
        """Give up the fishes' part, for the next renderer; this one can only be released then."""
        return self.disown(self._fishes)

    def resume(self) -> None:
        """Make the context current again, after this thread has used another one."""
        self._context.__enter__()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the first picture in pixels."""
        return self.rig.outputs[0]

    @property
    def pictures(self) -> dict[tuple[int, int], Any]:
        """The renderer's own pictures: textures by output and page."""
        return self._target.pictures

    def arrange(self, rig: CameraRig) -> None:
        """Draw for another rig from now on; a UserError if the GPU cannot, without effect."""
        if rig is not self.rig:
            if rig.pixels != self.rig.pixels:
                self._make_target(rig, self.quality)
            self.rig = rig
            self._resolve.arrange(rig.patches)

    def adapt(self, quality: Quality) -> None:
        """Draw in this quality from now on; a UserError if the GPU cannot, without effect."""
        before = self.quality
        if before.canvas != quality.canvas:
            self._make_target(self.rig, quality)
        self.quality = quality
        for part in (
            self._particles, self._seaweed, self._shafts, self._sun, self._seabed, self._water,
            self._resolve,
        ):  # fmt: skip
            part.adapt(quality)
        if self._second:
            self._second.adapt(quality)

    def choose(self, packet: Packet) -> None:
        """Choose the levels of detail of static geometry, which depend on earlier packets.

        Call it for packets that are not drawn, so that later pictures do not depend on that.
        """
        shown, when = self._coral.shown(self.quality.growth), (packet.views, packet.time_s)
        self._rocks.choose(*when, self.quality.detail, bites=packet.bites)
        self._coral.choose(*when, self.quality.detail, shown, packet.bites)
        self._seabed.choose(*when, self.quality.detail)

    @contextmanager
    def apart(self, rig: CameraRig) -> Iterator[None]:
        """Draw for another rig, with other `pictures`, independent of those before and after."""
        before, second = self.rig, self._second
        batches = self._rocks, self._coral, self._seabed
        self._make_target(rig, self.quality)
        if second is None:
            second = ResolvePass(self._context, rig.patches, grade=self._scene.grade)
            self.own(second).adapt(self.quality)
        second.arrange(rig.patches)
        levels = [batch.recall() for batch in batches]
        self._resolve, self._second = second, self._resolve
        try:
            yield
        finally:
            self._resolve, self._second = self._second, self._resolve
            for batch, level in zip(batches, levels, strict=True):
                batch.recall(level)
            self._make_target(before, self.quality)

    def develop(self, grade: Grade) -> None:
        """Develop the light of pictures by another grade from now on."""
        self._resolve.grade = grade

    def draw(self, packet: Packet, into: Into = OWN) -> None:
        """Draw every view of a packet and resolve the canvas to the outputs.

        `into` are framebuffers by output; the other outputs are drawn into the renderer's own
        `pictures`, which `read_pixels` returns. Waits until the GPU has drawn the picture before:
        it works on one while the next is computed, and never falls behind by two.
        """
        start = time.perf_counter()
        self.gpu_s = self.timer.wait()
        self.waited_s = time.perf_counter() - start
        calls, seconds = self._context.extra.calls, self._context.extra.seconds
        with self.timer.picture():
            self._fill(packet)
            self._show_canvas(self._target.resolved(), into)
        self.draw_calls = self._context.extra.calls - calls
        self.draw_s = self._context.extra.seconds - seconds

    def expose(self, packet: Packet, first: bool) -> None:
        """Draw every view of a packet, and add its light to a sum, which the `first` packet begins.

        `show_exposure` shows the mean.
        """
        with self.timer.picture():
            self._fill(packet)
        if self._exposure is None or self._exposure.size != self._target.size:
            if self._exposure:
                self._exposure.release()
            self._exposure = self.own(ExposureSum(self._context, self._target.size))
        self._exposure.add(self._target.resolved(), first)

    def show_exposure(self, into: Into = OWN) -> None:
        """Resolve the mean light of the packets exposed so far to the outputs."""
        if self._exposure is None or not self._exposure.pictures:
            raise ValueError("nothing has been exposed")
        self._exposure.write(self._target.flat)
        smooth = self._resolve.smooth
        # Smoothing by contrast makes crosses of small bubbles, and samples have smoothed the edges.
        self._resolve.smooth = smooth and not self.quality.samples
        self._show_canvas(self._target.canvas, into)
        self._resolve.smooth = smooth

    def _show_canvas(self, canvas: Any, into: Into) -> None:
        with self.timer.stage("output"):
            self._show(canvas, into, self._scale(self.rig, self.quality), self._target.unit)

    def _fill(self, packet: Packet) -> None:
        """Draw every view of a packet into the canvas."""
        places = [self._on_canvas(view).viewport for view in packet.views]
        # Water fills all that nothing else covers.
        self._target.begin(tile(places, self._target.size))
        start = time.perf_counter()
        self._fishes.upload(packet)
        self._seaweed.upload(packet)
        self._particles.upload(packet)
        self._lines.upload(packet)
        self.choose(packet)
        if self.quality.shadows:
            self._shadows.upload(packet, not self.quality.fish_map)
        self.upload_s = time.perf_counter() - start
        self.triangles = self._draw_views(packet, self._target.framebuffer, self._target.unit)

    def _draw_views(
        self, packet: Packet, framebuffer: Any, unit: float, passes: bool = False
    ) -> int:
        """Draw all views of a packet whose content is uploaded; returns the number of triangles.

        With `passes` the parts of their light: `framebuffer` has an attachment for each.
        """
        context, triangles = self._context, 0
        self._caustics.use(TEXTURE_UNITS["u_caustics"])
        self._noise.use(TEXTURE_UNITS["u_noise"])
        context.enable(context.PROGRAM_POINT_SIZE)
        context.depth_func = "<="  # water lies on the far plane
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA
        eye, stage = None, self.timer.stage
        if not passes:
            with stage("shadows"):
                self._shaded = self._cast(packet)
        wanted = self._shaded | ({"u_passes": True} if passes else {})
        for number, view in enumerate(map(self._on_canvas, packet.views)):
            uniforms = uniforms_of(packet, view, self._scene.water, unit) | wanted
            if uniforms["u_eye"] != eye:  # views through one eye share their shafts
                with stage("shafts"):
                    self._shafts.draw(uniforms)
            eye = uniforms["u_eye"]
            framebuffer.use()
            context.viewport = context.scissor = view.viewport  # points must not cross the edge
            context.disable(context.BLEND)
            context.enable(context.DEPTH_TEST)
            context.wireframe = self.wireframe
            context.enable(context.CULL_FACE)
            with stage("stone"):
                triangles += self._rocks.draw(number, uniforms)
            with stage("corals"):
                triangles += self._coral.draw(number, uniforms)
            context.disable(context.CULL_FACE)
            with stage("seaweed"):
                triangles += self._seaweed.draw(packet, number, uniforms)
            with stage("sand"):
                triangles += self._seabed.draw(number, uniforms)
            if self.quality.shadows and self.bodies and not self.wireframe:
                context.enable(context.BLEND)
                framebuffer.depth_mask = False  # shadows may overlap
                with stage("shadows"):
                    triangles += self._shadows.draw(uniforms)
                framebuffer.depth_mask = True
                context.disable(context.BLEND)
            context.wireframe = False
            with stage("water"):
                triangles += self._water.draw(view, uniforms)
            context.enable(context.BLEND)
            context.wireframe = self.wireframe
            with stage("fishes"):
                if self.bodies:
                    triangles += self._fishes.draw(packet, number, uniforms)
                triangles += self._hook.draw(packet, number, uniforms)
            context.wireframe = False
            framebuffer.depth_mask = False
            with stage("particles"):
                triangles += self._bubbles.draw(packet, number, uniforms)
                triangles += self._particles.draw(packet, number, uniforms)
                triangles += self._lines.draw(packet, number, view, uniforms)
            if not passes:
                self.vessel.draw(self.rig, number, np.array(self._scene.water.far), unit)
                self.overlay.draw(self.rig, number, unit)
            framebuffer.depth_mask = True
        context.scissor = None
        return triangles

    def _cast(self, packet: Packet) -> dict[str, Any]:
        """Draw the maps of shadows; returns their uniforms, and those that select programs."""
        chosen = {"u_close_up": self.quality.close_up, "u_integers": self.quality.integers}
        wants = {name: True for name, wanted in chosen.items() if wanted}
        if not self._sun.maps:
            return wants
        eye = middle_eye(packet.views)
        fishes = partial(self._fishes.cast, len(packet.instances) if self.bodies else 0)
        standing = (
            partial(self._rocks.cast, level=rocks.CAST_LEVEL),
            partial(self._coral.cast, level=coral.CAST_LEVEL),
        )
        maps = self._sun.draw(standing, fishes, eye, water_of(packet, self._scene.water).hour)
        return maps | wants

    def show(self, canvas: Bytes, into: Into = OWN, marks: Mapping[int, Array] = NO_MARKS) -> None:
        """Show a pattern (h, w, 3) of the canvas size, top row first, without tone mapping.

        `marks` are drawn over the patches of these numbers, as `MarkRenderer.draw` takes them.
        """
        texture = self._upload(canvas)
        try:
            self._show(texture, into, 1.0)
        finally:
            texture.release()
        if marks and self._marks is None:
            self._marks = self.own(MarkRenderer(self._context))
        for number, triangles in marks.items():
            patch = self.rig.patches[number]
            self._use(patch, into)
            if self._marks is not None:
                self._marks.draw(triangles, patch.place)

    def id_maps(
        self, packet: Packet, numbers: Sequence[int] | None = None, part: Rect | None = None
    ) -> IdMaps:
        """Draw the object ids and depths of the packet that was drawn last.

        Only of the views with these `numbers`, and of a `part` of the canvas, if given. Pixels
        outside all views are water.
        """
        context, size = self._context, self._target.size
        if self._ids is None or self._ids.size != size:
            if self._ids:
                self._ids.release()
            self._ids = self.own(IdBuffer(context, size))
        self._ids.framebuffer.use()
        self._ids.framebuffer.clear()
        self._noise.use(TEXTURE_UNITS["u_noise"])
        context.enable(context.PROGRAM_POINT_SIZE | context.DEPTH_TEST)
        context.disable(context.BLEND)
        context.depth_func = "<="
        for number, view in enumerate(map(self._on_canvas, packet.views)):
            if numbers is not None and number not in numbers:
                continue
            uniforms = uniforms_of(packet, view, self._scene.water)
            context.viewport = context.scissor = view.viewport
            context.enable(context.CULL_FACE)
            self._rocks.draw(number, uniforms, as_ids=True)
            self._coral.draw(number, uniforms, as_ids=True)
            context.disable(context.CULL_FACE)
            self._seabed.draw(number, uniforms, as_ids=True)
            self._water.draw_surface(view, uniforms, as_ids=True)
            for moving in (self._seaweed, self._fishes, self._hook, self._bubbles):
                moving.draw(packet, number, uniforms, as_ids=True)
        context.scissor = None
        scale = self._scale(self.rig, self.quality)
        return self._ids.read(None if part is None else scaled(part, scale))

    def light(self, output: int = 0) -> Array:
        """The light (h, w, 3) of the last picture, float32, top row first, before it is developed.

        Only of an output that shows a part of the canvas pixel by pixel.
        """
        return self._target.light(self._shown_by(output))

    def light_parts(self, packet: Packet, output: int = 0) -> LightParts:
        """Draw the parts of the light of the packet that was drawn last."""
        size, samples = self._target.size, self._target.samples
        if self._parts is None or (self._parts.size, self._parts.samples) != (size, samples):
            if self._parts:
                self._parts.release()
            self._parts = self.own(PartsTarget(self._context, size, samples))
        self._parts.framebuffer.use()
        self._parts.framebuffer.clear()
        self._draw_views(packet, self._parts.framebuffer, 1.0, passes=True)
        return self._parts.read(self._shown_by(output))

    def _shown_by(self, output: int) -> Rect:
        """The part of the canvas that an output shows pixel by pixel."""
        scale = self._scale(self.rig, self.quality)
        (patch,) = (one for one in self.rig.patches if one.output == output)
        part = scaled(patch.left, scale)
        if patch.shape != Projection.FLAT or part[2:] != self.rig.outputs[output]:
            raise ValueError("this output does not show its canvas pixel by pixel")
        return part

    def paste(self, picture: Bytes, patches: Sequence[DisplayPatch], into: Into = OWN) -> None:
        """Draw a picture (h, w, 3), top row first, over the outputs without tone mapping.

        The sources of `patches` are parts of the picture; `into` is as for `draw`.
        """
        if self._overlay is None:
            self._overlay = self.own(ResolvePass(self._context, patches))
        elif self._overlay.patches != tuple(patches):
            self._overlay.arrange(patches)
        texture = self._upload(picture)
        try:
            for number, patch in enumerate(patches):
                target = self._use(patch, into)
                size = self.rig.outputs[patch.output]
                self._overlay.draw(texture, target, size, number, 1.0, None)
        finally:
            texture.release()

    def _upload(self, picture: Bytes) -> Any:
        """Upload a picture (h, w, 3), top row first; the caller releases the texture."""
        return upload(self._context, picture[::-1])

    def read_pixels(self, output: int = 0, page: int = 0) -> Bytes:
        """The last of the renderer's own `pictures`: (h, w, 3), top row first.

        They have 16 bits if the quality is `deep`, else 8.
        """
        picture: Bytes = self._target.picture(output, page)
        return picture

    def _show(self, canvas: Any, into: Into, scale: float, unit: float | None = None) -> None:
        """Draw every patch of the rig from the canvas to its output.

        The canvas holds `unit` for a light of 1, or final colours if None.
        """
        begun = set()
        for number, patch in enumerate(self.rig.patches):
            output = patch.output, patch.page
            size = self.rig.outputs[patch.output]
            target = self._use(patch, into)
            if output not in begun and not self._filled(output):
                self._context.viewport = (0, 0, *size)
                target.clear()  # dark outside the patches
            begun.add(output)
            self._resolve.draw(canvas, target, size, number, scale, unit)

    def _filled(self, output: tuple[int, int]) -> bool:
        """True if patches fill a page of an output, so that nothing of it stays dark."""
        patches = [p for p in self.rig.patches if (p.output, p.page) == output]
        places = [patch.place for patch in patches]
        moved = any(patch.warp is not None or patch.adjustment is not None for patch in patches)
        return not moved and tile(places, self.rig.outputs[output[0]])

    def _use(self, patch: DisplayPatch, into: Into) -> Any:
        """The framebuffer for a patch, now in use: of `into`, or the renderer's own."""
        picture = self._target.framebuffers[patch.output, patch.page]
        target = into.get(patch.output, picture)
        target.use()
        if target is not picture:
            self._page(patch.page)  # applies to the framebuffer in use
        return target

    def _make_target(self, rig: CameraRig, quality: Quality) -> None:
        """Replace the canvas and the pictures for another rig or quality."""
        canvas = scaled((0, 0, *rig.canvas), self._scale(rig, quality))[2:]
        limit = self._context.info["GL_MAX_TEXTURE_SIZE"]
        what = " and ".join(f"{width}x{height}" for width, height in rig.outputs)
        if max(canvas) > limit:
            raise UserError(
                f"pictures of {what} need a canvas of {canvas[0]}x{canvas[1]} pixels, "
                f"this GPU holds at most {limit} a side"
            )
        try:
            samples = min(quality.samples, self._context.max_samples)
            target = RenderTarget(self._context, canvas, samples, rig.outputs, rig.pages, quality)
        except moderngl.Error as fault:
            raise UserError(
                f"pictures of {what} are more than this GPU can hold; take a smaller --size"
            ) from fault
        self._sized.release()
        self.rig, self._target = rig, self._sized.own(target)

    def _scale(self, rig: CameraRig, quality: Quality) -> float:
        """The size of the canvas over that of the rig's."""
        return 1.0 if rig.exact else quality.scale

    def _on_canvas(self, view: View) -> View:
        """The view with its viewport on the canvas."""
        scale = self._scale(self.rig, self.quality)
        # An unchanged view keeps its cached planes.
        return view if scale == 1.0 else replace(view, viewport=scaled(view.viewport, scale))
