"""Draw the sea for the windows of a dive; adapt quality to hold the frame time."""

import gc
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
from imgui_bundle import imgui

from subsea.base.arrays import Array, Bytes
from subsea.base.language import marked, translated
from subsea.dive import adaptive_quality
from subsea.dive.options import RETINA_COLOURS, DisplayOptions, RetinaColours
from subsea.dive.picking import pick
from subsea.dive.ride import (
    Ride,
    joined,
    pasted,
    pictured,
    retina_brightness,
    velocity_of,
    with_insets,
)
from subsea.frame.diagrams import DiagramBuilder, Label
from subsea.frame.packet import Packet, make_scene, pack
from subsea.media.exposure import Exposure
from subsea.rendering.fish.fishes import FishRenderer
from subsea.rendering.gl.id_buffer import FISH
from subsea.rendering.gl.textures import ImageTexture
from subsea.rendering.output.quality import (
    AUTO,
    CHOICES,
    LADDER,
    PRESETS,
    Quality,
    first_rung,
    name_of,
)
from subsea.rendering.renderer import BakedScene, Renderer
from subsea.ui.window_set import WindowSet
from subsea.view.camera import View
from subsea.view.display_rigs import DISPLAYS, HEADSET, display_rig
from subsea.view.fisheye import Fisheye
from subsea.view.front_screen import WHOLE, FrontView, TextViewport, front_screen, text_viewports
from subsea.view.levels import empty_lod_state
from subsea.view.retina import fish_eyes, retina_rig, retinal_views
from subsea.view.rig import CameraPose, CameraRig, Rect, levelled, views
from subsea.view.stereo import PAGED
from subsea.view.structured_light import bare, lit_picture
from subsea.view.theatre_vessel import PANEL_SIZE
from subsea.world.world import World

CanvasMaker = Callable[[CameraRig], Bytes]  # makes a canvas (h, w, 3) for a rig


def _test_pattern(rig: CameraRig) -> Bytes:
    from subsea.view.test_pattern import lineup  # needs Pillow

    return lineup(rig)


@contextmanager
def recovering_errors() -> Iterator[None]:
    """End all open scopes of ImGui if drawing fails within."""
    before, io = imgui.internal.ErrorRecoveryState(), imgui.get_io()
    imgui.internal.error_recovery_store_state(before)
    try:
        yield
    except Exception:
        io.config_error_recovery_enable_assert = False
        imgui.internal.error_recovery_try_to_recover_state(before)
        io.config_error_recovery_enable_assert = True
        raise


class ScenePicture:
    """Draws a world for a set of windows.

    Seen from the submarine's `eye` or from a ridden fish; with diagrams and retina
    pictures, or a test pattern instead.
    """

    def __init__(
        self,
        window_set: WindowSet,
        fixed: CameraRig | None,
        display: DisplayOptions,
        head: Any = None,
    ) -> None:
        """Start without a world.

        The rig is the `fixed` one, or that of the `head`, else that of the display mode.
        """
        self.display = display.mode if head or display.mode != HEADSET else "mono"
        self._spare: FishRenderer | None = None  # between two worlds
        self.head = (
            head  # a display on the head, as `stage.headset.display.HeadsetDisplay`; or None
        )
        self.quality = display.quality
        self.alpha = 1.0  # the shown point between the last two ticks
        self.eye: CameraPose
        self.rig: CameraRig
        self.ride: Ride | None = None
        self.pattern = False  # True if the test pattern or structured light is shown
        self.colours: RetinaColours = "colours"  # of retina pictures
        self.eyes_shown = True  # True if retina pictures are shown
        self.diagrams = set(display.diagrams)  # names in `diagrams.DIAGRAMS`
        self.wireframe = display.wireframe  # draw edges of triangles
        self.bodies = True  # False: fishes are hidden, but not their diagrams
        self.overlay: Fisheye | None = None  # a picture over the sea
        self.labels: Sequence[Label] = ()  # of diagrams
        # Of a picture that gathers light, and the number of the next point on it; all are taken
        # when that is the number of samples, and their mean is shown.
        self.lens: tuple[Exposure, int] | None = None
        self.viewports: tuple[TextViewport, ...]  # for text
        self._window_set, self._fixed, self._options = window_set, fixed, display
        self.insets: tuple[Rect, ...] = ()  # of retina pictures on the canvas
        self._wanted_pattern = False  # what a presenter last wanted
        self._canvas: CanvasMaker = _test_pattern  # draws the pattern ...
        self._marks: Mapping[int, Array] = {}  # ... and over it, by patch
        self._wanted_light: tuple[int, int] | None = None
        self._light: tuple[int, int] | None = None  # channel and number of its structured light
        self._saw: tuple[Ride, int] | None = None  # the last ride and tick that saw the light
        self._drawn: Packet | None = None
        self._seen: tuple[View, ...] = ()  # views of the current picture
        self._context = window_set.context
        renderer = self._context.info["GL_RENDERER"]
        self.target_ms = display.target_ms or adaptive_quality.target_for(renderer)
        self._take_rig()
        self._pace = adaptive_quality.start(first_rung(renderer), self.rig.exact)

    def open_world(
        self,
        world: World,
        check: Callable[[], object] = lambda: None,
        baked: BakedScene | None = None,
    ) -> None:
        """Draw this world from now on; `close_world` ended the one before.

        `check` is called while loading, and may raise. `baked` is its scene, if there was time.
        """
        fishes, self._spare = self._spare, None
        try:
            self.renderer = Renderer(
                self._context,
                make_scene(world),
                self.rig,
                self._chosen(),
                self._window_set.page,
                check,
                baked,
                fishes,
            )
        except BaseException as fault:
            # Release objects while the context exists: later it would crash.
            traceback.clear_frames(fault.__traceback__)
            gc.collect()
            raise
        self._world, self._drawn, self._seen, self.ride = world, None, (), None
        if self.head is not None:
            world.observers.append(self.head.feel)
        self._sketcher = DiagramBuilder(world)
        self.jump()

    def close_world(self) -> None:
        """Release the world's renderer."""
        self.renderer.release()

    def keep_fishes(self) -> None:
        """Keep the fishes' part of the renderer for the next world; call it before closing."""
        self._spare = self.renderer.give_fishes()

    def jump(self) -> None:
        """Reset fades before a picture from another place or time."""
        self._memory = empty_lod_state(len(self._world.state.fishes.species))

    def draw(self, clear: bool, chosen: int | None) -> None:
        """Draw the picture.

        Retina pictures need a `clear` corner. Diagrams of the fish that is `chosen` or ridden are
        stronger.
        """
        if self.head is not None:
            self.head.begin()
        if self._fixed is None and self._window_set.front.size != self.rig.outputs[0]:
            self._take_rig()
            self.arrange(clear)
        elif bool(self.insets) != self._with_insets(clear):
            self.arrange(clear)
        if not self.pattern:
            self._draw(chosen)
        if self.pattern or not self._direct:
            self._window_set.show(self.renderer.pictures)

    def end(self, vignette: float) -> None:
        """Show the picture in the headset, if there is one, with the text drawn since `draw`."""
        if self.head is not None:
            light = np.sqrt(self._world.scenario.water.far)  # a final colour
            self.head.end(self.rig, light, vignette)
        elif self.text_panel is not None:
            self._context.screen.use()

    def recentre(self) -> None:
        """Take the place of the head in a headset, if there is one, as the pilot's."""
        if self.head is not None:
            self.head.recentre()

    def put_on(self, head: Any) -> None:
        """Go on in a headset."""
        self.head = head
        self._world.observers.append(head.feel)
        self.show_as(HEADSET)

    def take_off(self) -> None:
        """Go on without the headset."""
        if self.head is not None:
            self._world.observers.remove(self.head.feel)
        self.close()
        self._window_set.gamepads.read_hands = lambda: None
        self._window_set.wait_for_display(True)
        self.show_as("mono")

    def close(self) -> None:
        """End the session of the headset, if there is one."""
        if self.head is not None:
            self.head.close()
            self.head = None

    def darken(self, rgb: tuple[float, float, float], opacity: float) -> None:
        """Blend a colour over the whole picture, in all windows and for all eyes."""
        self._window_set.darken((*rgb, opacity))

    def upload(self, pixels: Bytes) -> ImageTexture:
        """Make a texture for panels and the menu from pixels (h, w, 3); they must release it."""
        return ImageTexture(self._context, pixels)

    def arrange(self, clear: bool = True) -> None:
        """Set up the renderer for the rig, with retina pictures or a test pattern."""
        rig, self.insets = with_insets(self.rig) if self._with_insets(clear) else (self.rig, ())
        self._seen = ()
        self.renderer.arrange(rig if self._light is None else bare(rig))
        self._draw_pattern()

    def show_pattern(self, clear: bool) -> None:
        """Toggle the test pattern; this ends structured light."""
        self.pattern = not self.pattern
        self._light = None
        self._pace = adaptive_quality.resumed(self._pace)
        self.arrange(clear)

    def follow_pattern(self, wanted: bool, clear: bool) -> None:
        """Show or hide the test pattern when a presenter's wish changes."""
        if wanted != self._wanted_pattern:
            self._wanted_pattern = wanted
            if self.pattern != wanted:
                self.show_pattern(clear)

    def fit(
        self, rig: CameraRig, canvas: CanvasMaker | None, marks: Mapping[int, Array], clear: bool
    ) -> None:
        """Take another fixed rig, and show a canvas with marks instead of the sea; None: the sea.

        Both are as `Renderer.show` takes them. This ends structured light.
        """
        self._fixed, self._canvas, self._marks = rig, canvas or _test_pattern, marks
        self._light = None
        self._take_rig()
        if self.pattern != (canvas is not None):
            self.pattern = canvas is not None
            self._pace = adaptive_quality.resumed(self._pace)
        self.arrange(clear)

    def follow_light(self, wanted: tuple[int, int] | None, clear: bool) -> None:
        """Show or hide structured light: the number of a channel and of its picture."""
        if wanted == self._wanted_light:
            return
        stays = (wanted is None) == (self._light is None)
        self._wanted_light = self._light = wanted
        self.pattern = wanted is not None
        if stays:
            self._draw_pattern()
        else:
            self._pace = adaptive_quality.resumed(self._pace)
            self.arrange(clear)

    def show_as(self, display: str) -> None:
        """Change to another display mode, one of `displays`."""
        self.display = display
        self._take_rig()
        self._pace = adaptive_quality.start(self._pace.rung, self.rig.exact)
        self.arrange()

    @property
    def displays(self) -> tuple[str, ...]:
        """The display modes to choose from; none if the rig is fixed."""
        if self._fixed is not None or self.display in (PAGED, HEADSET):
            return ()
        return tuple(name for name in DISPLAYS if name != PAGED)

    def choose(self, quality: str) -> None:
        """Set the quality, one of `render.output.quality.CHOICES`."""
        self.quality = quality
        self._pace = adaptive_quality.resumed(self._pace)
        self.renderer.adapt(self._chosen())
        self._draw_pattern()

    def choose_next(self) -> None:
        """Set the next quality, cyclically."""
        self.choose(CHOICES[(CHOICES.index(self.quality) + 1) % len(CHOICES)])

    def next_colours(self) -> None:
        """Set the next colours of retina pictures, cyclically."""
        following = RETINA_COLOURS.index(self.colours) + 1
        self.colours = RETINA_COLOURS[following % len(RETINA_COLOURS)]

    @property
    def quality_text(self) -> str:
        """The quality, as a text."""
        name = name_of(self.renderer.quality)
        words = (
            marked("picture {quality}")
            if self.quality != AUTO
            else marked("picture auto: {quality}")
        )
        return translated(words).format(quality=translated(name))

    def adapt_quality(self, spent_s: float) -> None:
        """Adapt automatic quality to the time `spent_s` on this picture, without the display's.

        The GPU still draws it. The frame takes the longer of this time and that of the GPU, which
        is known of the picture before.
        """
        if self.quality != AUTO or self.pattern or self.lens is not None:
            return  # a change would begin the samples through a lens again
        frame_ms = 1000.0 * max(spent_s, self.renderer.gpu_s)
        self._pace = adaptive_quality.paced(self._pace, frame_ms, self.target_ms)
        if self._chosen() != self.renderer.quality:
            self.renderer.adapt(self._chosen())

    def finish(self) -> None:
        """Wait until all drawing is complete."""
        self._context.finish()

    def views(self) -> tuple[View, ...]:
        """The views from the submarine, or from the ridden fish."""
        rig = self.rig if self.head is None else self.head.moved(self.rig)
        if self.ride is None and self.lens is not None:
            return self.lens[0].through_lens(views(rig, self.observer), self.lens[1])
        if self.ride is None:
            return views(rig, self.observer)
        return self.ride.views(self._world, rig, self.insets, self.alpha)

    @property
    def observer(self) -> CameraPose:
        """The pose that carries the eyes of the rig."""
        if self.ride is not None:
            return self.ride.observer(self._world, self.alpha)
        return self.eye if self.head is None else self.head.turned(self.eye)

    @property
    def text_panel(self) -> TextViewport | None:
        """The viewport of the panel in a theatre's vessel, shown with the next picture; or None."""
        vessel = self.rig.vessel if self.head is None and self.ride is None else None
        if vessel is None or vessel.panel_angle is None:
            return None
        width, height = self._window_set.front.points
        shape = width / height * PANEL_SIZE[1] / PANEL_SIZE[0]
        return WHOLE._replace(screen=(1.0, shape), page=self._use_panel)

    @property
    def front_view(self) -> FrontView | None:
        """The view on the screen ahead; None if that is not a flat picture."""
        if self.head is not None:
            return self.head.front_view(self.rig, levelled(self.observer))
        return front_screen(self.rig, self._seen or self.views())

    def fish_at(self, x: float, y: float) -> int | None:
        """The fish at a place on the screen, in shares of it from its upper left."""
        if self._drawn is None or self.pattern:
            return None
        picked = pick(self.renderer, self._drawn, x, y)
        self._context.screen.use()  # text is still to be drawn over the picture
        return picked.number if picked is not None and picked.kind == FISH else None

    def depth_at(self, x: float, y: float) -> float | None:
        """Distance along the view, cm, of what is at a place as `fish_at`; None in open water."""
        front_view = self.front_view
        if self._drawn is None or front_view is None:
            return None
        picked = pick(self.renderer, self._drawn, x, y)
        self._context.screen.use()
        if picked is None or not np.isfinite(picked.place).all():
            return None
        ahead = -front_view.view.view[2, :3]
        return float(ahead @ (picked.place - front_view.view.eye))

    def blacken(self, opacity: float) -> None:
        """Draw black over what was drawn so far."""
        self.darken((0.0, 0.0, 0.0), opacity)

    def see_light(self) -> None:
        """Let the ridden fish react to the light it sees now, until the next picture."""
        if self.ride is None or self._saw == (now := (self.ride, self._world.state.tick)):
            return
        self._saw = now
        light = retina_brightness(self.renderer, self._world, self.ride.by)
        self._world.seen_light[self.ride.by.fish] = light
        self._draw_pattern()  # the renderer's pictures were overwritten

    def through_eyes(self, fish: int, size: tuple[int, int]) -> Bytes:
        """Draw what both eyes of a fish see, in the present colours: (h, 2 w, 3), side by side.

        Call it between frames: it overwrites the renderer's pictures.
        """
        by = fish_eyes(self._world, fish)
        rig = retina_rig(size, by.half_cm)
        with self.renderer.apart(rig):
            packet = pack(self._world, retinal_views(self._world, by, rig, self.alpha), self.alpha)
            self.renderer.draw(packet)
            if self.colours == "colours":
                pixels = np.hstack([self.renderer.read_pixels(side) for side in range(2)])
            else:
                pixels = pictured(self.renderer.id_maps(packet), self.colours)
        self._draw_pattern()
        return pixels

    @property
    def counts(self) -> dict[str, int]:
        """Counts of fishes and triangles, in all and in the picture."""
        fishes, drawn = self._world.state.fishes, self._drawn
        return {
            "fishes": int(np.count_nonzero(fishes.alive)),
            "simulated": int(np.count_nonzero(fishes.live)),
            "in sight": 0 if drawn is None else len(fishes.alive) - drawn.hidden,
            "triangles": self.renderer.triangles,
        }

    @property
    def _direct(self) -> bool:
        """True if the picture is drawn straight into the only window."""
        only = len(self._window_set.windows) == 1
        return only and self.rig.outputs[0] == self._window_set.front.size

    def _with_insets(self, clear: bool) -> bool:
        shown = self.eyes_shown and self.head is None
        return self.ride is not None and shown and clear and not self.pattern

    def _draw(self, chosen: int | None) -> None:
        quality, ride = self.renderer.quality, self.ride
        into = {0: self._context.screen} if self._direct else {}
        if self.lens is not None and self.lens[1] >= self.lens[0].samples:
            self.renderer.show_exposure(into)
            return
        self._seen = seen = self.views()
        own = len(seen) - len(self.insets)  # retina pictures have no diagrams
        marked = chosen if ride is None else ride.by.fish
        lines, self.labels = self._sketcher.draw(self.diagrams, seen[:own], self.alpha, marked)
        self.renderer.wireframe, self.renderer.bodies = self.wireframe, self.bodies
        self.renderer.vessel.shown = ride is None
        self.renderer.overlay.shown = self.overlay
        packet = pack(
            self._world, seen, self.alpha, options=quality.packing,
            memory=self._memory, lines=lines, pilot=self.eye,
        )  # fmt: skip
        if self.head is not None:
            into |= self.head.targets
            self.rig = self.head.steadied(self.rig)
            self.renderer.arrange(self.rig)
        if self.head is not None and ride is None and packet.lamps is not None:
            packet = replace(packet, lamps=self.head.lamps(self.eye) or packet.lamps)
        if ride is not None:
            passing = velocity_of(self._world, ride.by.fish)
            packet = replace(packet, passing_cm_s=passing, lined=own)
        self._drawn = packet
        if self.lens is not None:
            self.renderer.expose(packet, first=self.lens[1] == 0)
            self.renderer.show_exposure(into)
            return
        self.renderer.draw(packet, into)
        if self.insets and self.colours != "colours":
            maps = self.renderer.id_maps(packet, range(own, len(seen)), joined(self.insets))
            picture = pictured(maps, self.colours)
            self.renderer.paste(picture, pasted(self.renderer.rig, self.rig, picture), into)

    def _draw_pattern(self) -> None:
        """Draw the test pattern, if shown, into the renderer's pictures, once."""
        if self._light is not None:
            self.renderer.show(lit_picture(self.renderer.rig, *self._light))
        elif self.pattern:
            self.renderer.show(self._canvas(self.rig), marks=self._marks)

    def _take_rig(self) -> None:
        """Set the rig for the current windows, and its text viewports."""
        size, options = self._window_set.front.size, self._options
        if self.head is not None:
            self.rig = self.head.rig(size)
        else:
            self.rig = self._fixed or display_rig(
                self.display, size, options.stereo, options.surround
            )
        self.viewports = text_viewports(self.rig, self._window_set.page)
        if self.head is not None:
            self.viewports = self.head.text_viewports(self.viewports[0])

    def _use_panel(self, number: int) -> None:
        panel = self.renderer.vessel.panel(self.rig)
        panel.use()
        panel.clear(0.0, 0.0, 0.0, 0.0)

    def _chosen(self) -> Quality:
        return LADDER[self._pace.rung] if self.quality == AUTO else PRESETS[self.quality]
