"""What a dive shows: the sea in the rig of its windows, as finely as there is time for."""

import gc
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from subsea.dive import adaptive_quality
from subsea.dive.options import RETINA_COLOURS, DisplayOptions, RetinaColours
from subsea.dive.picking import pick
from subsea.dive.retina_images import retina_brightness, velocity_of
from subsea.dive.ride import Ride, joined, pasted, pictured, with_insets
from subsea.frame.diagrams import DiagramBuilder
from subsea.frame.labels import Label
from subsea.frame.packet import Packet, make_scene, pack
from subsea.render import Renderer
from subsea.render.gl.id_buffer import FISH
from subsea.render.output.quality import (
    AUTO,
    CHOICES,
    LADDER,
    PRESETS,
    Quality,
    first_rung,
    name_of,
)
from subsea.ui.window_set import WindowSet
from subsea.view.camera import View
from subsea.view.display_rigs import DISPLAYS, display_rig
from subsea.view.levels import empty_lod_state
from subsea.view.rig import CameraPose, CameraRig, Rect, views
from subsea.view.stereo import PAGED
from subsea.view.text_viewports import TextViewport, text_viewports
from subsea.view.unproject import FrontView, front_screen
from subsea.world.world import World


class ScenePicture:
    """Draws one world after another for the windows of a wall.

    From the submarine, whose `eye` is told, or from a fish that is ridden; with diagrams, with what
    a fish's eyes see in the corners, or the test pattern instead of all.
    """

    def __init__(self, wall: WindowSet, fixed: CameraRig | None, display: DisplayOptions) -> None:
        """Of no world yet. The rig is the one that is `fixed`, else that of the display mode."""
        self.display = display.mode
        self.quality = display.quality
        self.alpha = 1.0  # the point between the last two ticks that is shown
        self.eye: CameraPose
        self.ride: Ride | None = None
        self.pattern = False  # whether the test pattern is shown
        self.colours: RetinaColours = "colours"  # of the pictures of a fish's eyes ...
        self.eyes_shown = True  # ... and whether there are any
        self.diagrams = set(display.diagrams)  # names of `diagrams.DIAGRAMS` that are drawn
        self.wireframe = display.wireframe  # whether the sea is drawn as the edges of its triangles
        self.labels: Sequence[Label] = ()  # of diagrams
        self.panes: tuple[TextViewport, ...]  # where text goes
        self._window_set, self._fixed, self._options = wall, fixed, display
        self.insets: tuple[Rect, ...] = ()  # where pictures of a fish's eyes are on the canvas
        self._drawn: Packet | None = None
        self._seen: tuple[View, ...] = ()  # the views of the present picture
        self._context = wall.context
        renderer = self._context.info["GL_RENDERER"]
        self.target_ms = display.target_ms or adaptive_quality.target_for(renderer)
        self._take_rig()
        self._pace = adaptive_quality.start(first_rung(renderer), self.rig.exact)

    def open_world(self, world: World, check: Callable[[], object] = lambda: None) -> None:
        """Draw this world from now on; the one before was left.

        That takes a while, in which `check` is called, and may raise.
        """
        try:
            self.renderer = Renderer(
                self._context,
                make_scene(world),
                self.rig,
                self._chosen(),
                self._window_set.page,
                check,
            )
        except BaseException as fault:
            # What was made of it goes while its context is there: later it would be a crash.
            traceback.clear_frames(fault.__traceback__)
            gc.collect()
            raise
        self._world, self._drawn, self._seen, self.ride = world, None, (), None
        self._sketcher = DiagramBuilder(world)
        self.jump()

    def close_world(self) -> None:
        """Release what is there for the world."""
        self.renderer.release()

    def jump(self) -> None:
        """What comes is seen from elsewhere, or at another time: nothing fades into it."""
        self._memory = empty_lod_state(len(self._world.state.fishes.species))

    def draw(self, clear: bool, chosen: int | None) -> None:
        """The sea, as the windows show it now.

        What a fish's eyes see needs a `clear` corner. Of the fish that is `chosen`, or ridden,
        diagrams are stronger.
        """
        if self._fixed is None and self._window_set.front.size != self.rig.outputs[0]:
            self._take_rig()
            self.arrange(clear)
        elif bool(self.insets) != self._with_insets(clear):
            self.arrange(clear)
        if not self.pattern:
            self._draw(chosen)
        if self.pattern or not self._direct:
            self._window_set.show(self.renderer.pictures)

    def arrange(self, clear: bool = True) -> None:
        """Have the renderer draw what is to be seen: the rig, what a fish's eyes see, a pattern."""
        rig, self.insets = with_insets(self.rig) if self._with_insets(clear) else (self.rig, ())
        self._seen = ()
        self.renderer.arrange(rig)
        self._draw_pattern()

    def show_pattern(self, clear: bool) -> None:
        """The test pattern, or again the sea."""
        self.pattern = not self.pattern
        self._pace = adaptive_quality.resumed(self._pace)
        self.arrange(clear)

    def show_as(self, display: str) -> None:
        """In another display mode from now on, one of `displays`."""
        self.display = display
        self._take_rig()
        self._pace = adaptive_quality.start(self._pace.rung, self.rig.exact)
        self.arrange()

    @property
    def displays(self) -> tuple[str, ...]:
        """The display modes that it may be shown in from now on; none where that is fixed."""
        if self._fixed is not None or self.display == PAGED:
            return ()
        return tuple(name for name in DISPLAYS if name != PAGED)

    def choose(self, quality: str) -> None:
        """Draw with this quality from now on, one of `render.quality.CHOICES`."""
        self.quality = quality
        self._pace = adaptive_quality.resumed(self._pace)
        self.renderer.adapt(self._chosen())
        self._draw_pattern()

    def choose_next(self) -> None:
        """The next quality, and after the finest the first again."""
        self.choose(CHOICES[(CHOICES.index(self.quality) + 1) % len(CHOICES)])

    def next_colours(self) -> None:
        """The next look of what a fish's eyes see."""
        following = RETINA_COLOURS.index(self.colours) + 1
        self.colours = RETINA_COLOURS[following % len(RETINA_COLOURS)]

    @property
    def quality_text(self) -> str:
        """How it is drawn, in words."""
        name = name_of(self.renderer.quality)
        return f"picture {name}" if self.quality != AUTO else f"picture auto: {name}"

    def adapt_quality(self, spent_s: Callable[[], float]) -> None:
        """Adapt the quality that chooses itself to how long this picture took until now."""
        if self.quality != AUTO or self.pattern:
            return
        self._context.finish()  # the time of the picture, without waiting for the display
        self._pace = adaptive_quality.paced(self._pace, 1000.0 * spent_s(), self.target_ms)
        if self._chosen() != self.renderer.quality:
            self.renderer.adapt(self._chosen())

    def finish(self) -> None:
        """Return when all that was asked for is drawn."""
        self._context.finish()

    def views(self) -> tuple[View, ...]:
        """What is seen from the submarine, or from the fish that is ridden."""
        if self.ride is None:
            return views(self.rig, self.eye)
        return self.ride.views(self._world, self.rig, self.insets, self.alpha)

    @property
    def sight(self) -> FrontView | None:
        """What the screen ahead shows now; None where that is no flat picture."""
        return front_screen(self.rig, self._seen or self.views())

    def fish_at(self, x: float, y: float) -> int | None:
        """The fish that is seen at a place on the screen, in shares of it from its upper left."""
        if self._drawn is None or self.pattern:
            return None
        picked = pick(self.renderer, self._drawn, x, y)
        self._context.screen.use()  # text goes on being drawn over the picture
        return picked.number if picked is not None and picked.kind == FISH else None

    def brightness(self, ride: Ride) -> float:
        """How bright it is in the eyes of the fish that is ridden, in [0, 1]."""
        light = retina_brightness(self.renderer, self._world, ride.by)
        self._draw_pattern()  # seeing has emptied the renderer's own pictures
        return light

    @property
    def counts(self) -> dict[str, int]:
        """How many of what there is, and of that in the present picture."""
        fishes, drawn = self._world.state.fishes, self._drawn
        return {
            "fishes": int(np.count_nonzero(fishes.alive)),
            "simulated": int(np.count_nonzero(fishes.live)),
            "in sight": 0 if drawn is None else len(fishes.alive) - drawn.hidden,
            "triangles": self.renderer.triangles,
        }

    @property
    def _direct(self) -> bool:
        """Whether the one window there is has the size of the picture: no need to copy it."""
        return self.rig.outputs == (self._window_set.front.size,)

    def _with_insets(self, clear: bool) -> bool:
        return self.ride is not None and self.eyes_shown and clear and not self.pattern

    def _draw(self, chosen: int | None) -> None:
        """The sea, into the window or into the renderer's own pictures."""
        quality, ride = self.renderer.quality, self.ride
        self._seen = seen = self.views()
        own = len(seen) - len(self.insets)  # what a fish's eyes see has no diagrams
        marked = chosen if ride is None else ride.by.fish
        lines, self.labels = self._sketcher.draw(self.diagrams, seen[:own], self.alpha, marked)
        self.renderer.wireframe = self.wireframe
        packet = pack(
            self._world, seen, self.alpha, detail=quality.detail, growth=quality.growth,
            memory=self._memory, lines=lines, pilot=self.eye,
        )  # fmt: skip
        into = self._context.screen if self._direct else None
        if ride is not None:
            passing = velocity_of(self._world, ride.by.fish)
            packet = replace(packet, passing_cm_s=passing, lined=own)
        self.renderer.draw(packet, into)
        self._drawn = packet
        if self.insets and self.colours != "colours":
            maps = self.renderer.id_maps(packet, range(own, len(seen)), joined(self.insets))
            picture = pictured(maps, self.colours)
            self.renderer.paste(picture, pasted(self.renderer.rig, self.rig, picture), into)

    def _draw_pattern(self) -> None:
        """The test pattern, if it is shown, into the renderer's own pictures: once is enough."""
        if self.pattern:
            from subsea.view.theatre.lineup import lineup

            self.renderer.show(lineup(self.rig))

    def _take_rig(self) -> None:
        """The rig that is for the windows as they are now, and where text goes on it."""
        self.rig = self._fixed or display_rig(
            self.display, self._window_set.front.size, self._options.stereo, self._options.surround
        )
        self.panes = text_viewports(self.rig, self._window_set.page)

    def _chosen(self) -> Quality:
        return LADDER[self._pace.rung] if self.quality == AUTO else PRESETS[self.quality]
