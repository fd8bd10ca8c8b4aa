"""The order of a picture: solids, seabed, water behind it, fishes, particles, then tone mapping."""

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.core.disk_cache import kept
from subsea.core.errors import UserError
from subsea.frame.packet import Packet, Scene
from subsea.render.fish.fishes import FishRenderer
from subsea.render.fish.soft_shadows import SoftShadowRenderer
from subsea.render.gl.id_buffer import IdBuffer, IdMaps
from subsea.render.gl.textures import near_and_far, noise, repeating
from subsea.render.output.lines import LineRenderer
from subsea.render.output.quality import PRESETS, Quality
from subsea.render.output.target import RenderTarget, ResolvePass, scaled
from subsea.render.output.uniforms import uniforms_of
from subsea.render.reef.coral import CoralRenderer, bake
from subsea.render.reef.rocks import RockRenderer, pieces
from subsea.render.reef.seaweed import SeaweedRenderer
from subsea.render.sea.bubbles import BubbleRenderer
from subsea.render.sea.hook import HookRenderer
from subsea.render.sea.light_shafts import LightShaftRenderer
from subsea.render.sea.particles import ParticleRenderer
from subsea.render.sea.seabed import SeabedRenderer, drawn_height, surroundings
from subsea.render.sea.water import WaterRenderer
from subsea.view.camera import View
from subsea.view.culling import IN_SIGHT
from subsea.view.rig import CameraRig, DisplayPatch, Rect


class Renderer:
    """Everything on the GPU for one dive. Draws packets; knows nothing of their origin."""

    def __init__(
        self,
        context: Any,
        scene: Scene,
        rig: CameraRig,
        quality: Quality = PRESETS["medium"],
        page: Callable[[int], object] = lambda number: None,
        heed: Callable[[], object] = lambda: None,
    ) -> None:
        """Make every object for the pictures of a `rig` in this `quality`.

        The packets' views must be the rig's. `page(0)`, `page(1)` choose the left or right buffer
        of a window that has two. `heed` is called now and then, and may raise.
        """
        self._context = context
        self._page = page
        self._scene = scene
        self.quality = quality
        self.wireframe = False  # whether triangles are drawn as their edges, the water as ever
        self.triangles = 0  # of the last picture
        self.draw_calls = 0  # of the last picture
        self.draw_s = 0.0  # of the last picture: until its drawing calls returned
        self.upload_s = 0.0  # of the last picture: copying the packet to the GPU
        # numpy and compiled kernels leave the interpreter to others, among them OpenGL's thread.
        with ThreadPoolExecutor() as pool:
            stands = scene.terrain, scene.terrain_half_width_cm, scene.pillars, scene.rocks
            stone = pool.submit(lambda: kept(pieces, *stands))
            ground = pool.submit(lambda: kept(surroundings, *stands))
            growths = pool.submit(bake, scene.reef)
            self._caustics = repeating(context, near_and_far, 1)
            self._noise = repeating(context, noise, 2)
            self._shafts = LightShaftRenderer(context, quality)
            heed()
            self._water = WaterRenderer(context, scene)
            heed()
            self._seabed = SeabedRenderer(context, scene, ground.result())
            heed()
            self._solids = RockRenderer(context, scene, stone.result())
            self._blobs = SoftShadowRenderer(context, scene)
            heed()
            self._coral = CoralRenderer(
                context, scene.reef, growths.result(), IN_SIGHT * scene.water.visibility_cm,
                partial(drawn_height, scene.terrain, scene.terrain_half_width_cm),
            )  # fmt: skip
            self._seaweed = SeaweedRenderer(context)
            heed()
            self._fishes = FishRenderer(context, scene)
        self._hook = HookRenderer(context)
        heed()
        self._bubbles = BubbleRenderer(context, scene)
        self._particles = ParticleRenderer(context, scene)
        self._lines = LineRenderer(context)
        self._resolve = ResolvePass(context, rig.patches, quality.smooth)
        self._held_for_size: list[Any] = []
        self._marks: IdBuffer | None = None  # made when it is first asked for
        self._pasted: ResolvePass | None = None  # likewise
        self._apart: ResolvePass | None = None  # likewise
        self._make_target(rig, quality)
        self.adapt(quality)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the first picture in pixels."""
        return self.rig.outputs[0]

    def arrange(self, rig: CameraRig) -> None:
        """Draw for another rig from the next packet on: another size, or another display.

        A UserError if the GPU cannot hold it: then it stays as it is.
        """
        if rig is not self.rig:
            self._make_target(rig, self.quality)
            self._resolve.arrange(rig.patches)

    def adapt(self, quality: Quality) -> None:
        """Draw in this quality from the next picture on.

        A UserError if the GPU cannot hold it: then it stays as it is.
        """
        before = self.quality
        if (before.scale, before.samples) != (quality.scale, quality.samples):
            self._make_target(self.rig, quality)
        self.quality = quality
        self._particles.adapt(quality)
        self._shafts.adapt(quality)
        self._water.adapt(quality)
        self._resolve.adapt(quality)
        if self._apart:
            self._apart.adapt(quality)

    def choose(self, packet: Packet) -> None:
        """Choose how finely everything that stands is drawn; this depends on earlier packets.

        For those who leave packets out but want what follows to be as if all had been drawn.
        """
        self._solids.choose(packet, self.quality.detail)
        self._coral.choose(packet.views, self.quality.detail, self.quality.growth)
        self._seabed.choose(packet, self.quality.detail)

    @contextmanager
    def apart(self, rig: CameraRig) -> Iterator[None]:
        """Draw for another rig in between: as if nothing had been drawn before.

        And what is drawn afterwards is as if nothing had been drawn in between; but the `pictures`
        are other ones, still empty.
        """
        before, standing = self.rig, [*self._solids.standing, *self._coral.standing]
        standing += self._seabed.standing
        self._make_target(rig, self.quality)
        if self._apart is None:
            self._apart = ResolvePass(self._context, rig.patches, self.quality.smooth)
        self._apart.arrange(rig.patches)
        levels = [one.recall() for one in standing]
        self._resolve, self._apart = self._apart, self._resolve
        try:
            yield
        finally:
            self._resolve, self._apart = self._apart, self._resolve
            for one, level in zip(standing, levels, strict=True):
                one.recall(level)
            self._make_target(before, self.quality)

    def draw(self, packet: Packet, into: Any = None) -> None:
        """Draw every view of a packet and show the result.

        `into` is a framebuffer for a rig with a single output. With None the outputs are the
        renderer's own `pictures`, which `read_pixels` returns.
        """
        context = self._context
        calls, seconds = context.extra.calls, context.extra.seconds
        self._target.framebuffer.use()
        self._target.framebuffer.clear()
        start = time.perf_counter()
        self._fishes.upload(packet)
        self._seaweed.upload(packet)
        self._particles.upload(packet)
        self._lines.upload(packet)
        self.choose(packet)
        if self.quality.shadows:
            self._blobs.upload(packet)
        self.upload_s = time.perf_counter() - start
        self._caustics.use(1)
        self._noise.use(2)
        self.triangles = 0
        context.enable(context.PROGRAM_POINT_SIZE)
        context.depth_func = "<="  # the water lies on the far plane
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA
        eye = None
        for number, view in enumerate(map(self._on_canvas, packet.views)):
            uniforms = uniforms_of(packet, view, self._scene.water)
            if uniforms["u_eye"] != eye:  # views through one eye have their shafts in common
                self._shafts.cast(uniforms)
            eye = uniforms["u_eye"]
            self._target.framebuffer.use()
            context.viewport = context.scissor = view.viewport  # specks must not spill over
            context.disable(context.BLEND)
            context.enable(context.DEPTH_TEST)
            context.wireframe = self.wireframe
            self.triangles += self._solids.draw(number, uniforms)
            context.enable(context.CULL_FACE)
            self.triangles += self._coral.draw(number, uniforms)
            context.disable(context.CULL_FACE)
            self.triangles += self._seaweed.draw(packet, number, uniforms)
            self.triangles += self._seabed.draw(number, uniforms)
            if self.quality.shadows and not self.wireframe:
                context.enable(context.BLEND)
                self._target.framebuffer.depth_mask = False  # shadows may lie on one another
                self.triangles += self._coral.draw_shadows(number, uniforms)
                self.triangles += self._blobs.draw(uniforms)
                self._target.framebuffer.depth_mask = True
                context.disable(context.BLEND)
            context.wireframe = False
            self.triangles += self._water.draw(view, uniforms)
            context.enable(context.BLEND)
            context.wireframe = self.wireframe
            self.triangles += self._fishes.draw(packet, number, uniforms)
            self.triangles += self._hook.draw(packet, number, uniforms)
            context.wireframe = False
            self._target.framebuffer.depth_mask = False
            self.triangles += self._bubbles.draw(packet, number, uniforms)
            self.triangles += self._particles.draw(packet, number, uniforms)
            self.triangles += self._lines.draw(packet, number, view, uniforms)
            self._target.framebuffer.depth_mask = True
        context.scissor = None
        self._show(self._target.picture(), into, self._scale(self.rig, self.quality), True)
        self.draw_calls = context.extra.calls - calls
        self.draw_s = context.extra.seconds - seconds

    def show(self, canvas: NDArray[np.uint8], into: Any = None) -> None:
        """Show a picture (h, w, 3), top row first, instead of what would be on the canvas.

        As it is, but warped and blended: a test pattern. Its size is that of the rig's canvas.
        """
        texture = self._upload(canvas)
        try:
            self._show(texture, into, 1.0, False)
        finally:
            texture.release()

    def look_up(
        self, packet: Packet, numbers: Sequence[int] | None = None, part: Rect | None = None
    ) -> IdMaps:
        """What each pixel of the canvas shows of the packet that was drawn last, and how far away.

        Of the views with these `numbers` alone, and of a `part` of the canvas, if they are given.
        Where no view is there is water.
        """
        context, size = self._context, self._target.size
        if self._marks is None or self._marks.size != size:
            if self._marks:
                self._marks.release()
            self._marks = IdBuffer(context, size)
        self._marks.framebuffer.use()
        self._marks.framebuffer.clear()
        self._noise.use(2)
        context.enable(context.PROGRAM_POINT_SIZE | context.DEPTH_TEST)
        context.disable(context.BLEND)
        context.depth_func = "<="
        for number, view in enumerate(map(self._on_canvas, packet.views)):
            if numbers is not None and number not in numbers:
                continue
            uniforms = uniforms_of(packet, view, self._scene.water)
            context.viewport = context.scissor = view.viewport
            self._solids.draw(number, uniforms, marked=True)
            context.enable(context.CULL_FACE)
            self._coral.draw(number, uniforms, marked=True)
            context.disable(context.CULL_FACE)
            self._seabed.draw(number, uniforms, marked=True)
            self._water.draw_surface(view, uniforms, marked=True)
            for moving in (self._seaweed, self._fishes, self._hook, self._bubbles):
                moving.draw(packet, number, uniforms, marked=True)
        context.scissor = None
        scale = self._scale(self.rig, self.quality)
        return self._marks.read(None if part is None else scaled(part, scale))

    def paste(
        self, picture: NDArray[np.uint8], patches: Sequence[DisplayPatch], into: Any = None
    ) -> None:
        """Lay a picture (h, w, 3), top row first, over what is shown, as it is.

        Of each of the `patches` the sources are parts of the picture; `into` is as for `draw`.
        """
        if self._pasted is None:
            self._pasted = ResolvePass(self._context, patches)
        elif self._pasted.patches != tuple(patches):
            self._pasted.arrange(patches)
        texture = self._upload(picture)
        try:
            for number, patch in enumerate(patches):
                target = self._own[patch.output, patch.page] if into is None else into
                target.use()
                if into is not None:
                    self._page(patch.page)
                size = self.rig.outputs[patch.output]
                self._pasted.draw(texture, target, size, number, 1.0, False)
        finally:
            texture.release()

    def _upload(self, picture: NDArray[np.uint8]) -> Any:
        """A picture (h, w, 3), top row first, as a texture; the caller releases it."""
        height, width = picture.shape[:2]
        data = np.ascontiguousarray(picture[::-1]).tobytes()
        texture = self._context.texture((width, height), 3, data, alignment=1)
        texture.repeat_x = texture.repeat_y = False
        return texture

    def read_pixels(self, output: int = 0, page: int = 0) -> NDArray[np.uint8]:
        """The last picture drawn into one of the renderer's own: (h, w, 3), top row first."""
        width, height = self.rig.outputs[output]
        data = self._own[output, page].read(components=3, alignment=1)
        return np.frombuffer(data, np.uint8).reshape(height, width, 3)[::-1]

    def release(self) -> None:
        """Free every OpenGL object."""
        self._release_target()
        for made in (self._marks, self._pasted, self._apart):
            if made:
                made.release()
        for part in (
            self._resolve, self._lines, self._particles, self._bubbles, self._hook, self._fishes,
            self._seaweed, self._coral, self._blobs, self._solids, self._seabed, self._water,
            self._shafts, self._noise, self._caustics,
        ):  # fmt: skip
            part.release()

    def _show(self, canvas: Any, into: Any, scale: float, linear: bool) -> None:
        """Take every patch of the rig from the canvas to its output."""
        begun = set()
        for number, patch in enumerate(self.rig.patches):
            output = patch.output, patch.page
            size = self.rig.outputs[patch.output]
            target = self._own[output] if into is None else into
            target.use()
            if into is not None:
                self._page(patch.page)  # a buffer is chosen of the framebuffer in use
            if output not in begun and (patch.place[2:] != size or patch.warp is not None):
                self._context.viewport = (0, 0, *size)
                target.clear()  # where no patch lies it is dark
            begun.add(output)
            self._resolve.draw(canvas, target, size, number, scale, linear)

    def _make_target(self, rig: CameraRig, quality: Quality) -> None:
        """Canvas and pictures of another rig or quality instead of those that there are."""
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
            target = RenderTarget(self._context, canvas, samples)
        except moderngl.Error as fault:
            raise UserError(
                f"pictures of {what} are more than this GPU can hold; take a smaller --size"
            ) from fault
        own, held = {}, [target]
        self.pictures: dict[tuple[int, int], Any] = {}  # textures by output and page
        for output, size in enumerate(rig.outputs):
            for page in range(rig.pages):
                picture = self._context.texture(size, 4)
                own[output, page] = self._context.framebuffer([picture])
                self.pictures[output, page] = picture
                held += [own[output, page], picture]
        self._release_target()
        self.rig, self._target, self._own, self._held_for_size = rig, target, own, held

    def _scale(self, rig: CameraRig, quality: Quality) -> float:
        """How much larger than the rig's the canvas is."""
        return 1.0 if rig.exact else quality.scale

    def _on_canvas(self, view: View) -> View:
        """The view in its place on the canvas."""
        scale = self._scale(self.rig, self.quality)
        # Its planes are known already if it stays the same.
        return view if scale == 1.0 else replace(view, viewport=scaled(view.viewport, scale))

    def _release_target(self) -> None:
        # moderngl binds the last framebuffer again when it makes one; it must not be a freed one.
        self._context.detect_framebuffer(0).use()
        for held in self._held_for_size:
            held.release()
