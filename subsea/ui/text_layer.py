"""Draw text, instruments, panels and menu over the pilot's picture."""

from subsea.dive.captions import caption_of
from subsea.dive.settings import Settings
from subsea.ui import subtitles
from subsea.ui.comfort import Vignette, draw_horizon
from subsea.ui.context import DiveContext
from subsea.ui.hud import instrument_reading
from subsea.ui.idle_tours import IdleTours
from subsea.ui.inspector import Inspector
from subsea.ui.labels import draw_labels
from subsea.ui.menu import Menu


class TextLayer:
    """Draws one frame of the gui over each picture."""

    def __init__(
        self, dive: DiveContext, settings: Settings, menu: Menu, inspector: Inspector
    ) -> None:
        self.vignette = Vignette(settings.comfort.vignette)
        self.horizon = settings.comfort.horizon  # whether to draw one at the helm
        self._dive, self._menu, self._inspector = dive, menu, inspector

    def draw(self, elapsed_s: float, tours: IdleTours) -> None:
        """Draw one frame, `elapsed_s` after the last.

        Draws nothing over the test pattern, which serves to measure projectors.
        """
        dive, picture, overlay = self._dive, self._dive.picture, self._dive.overlay
        if picture.pattern:
            return
        self._begin()
        draw_labels(picture.labels, picture.front_view)
        if not self._menu.open:  # nor draw a caption behind the help
            caption = caption_of(dive.world, picture.alpha)
            opacity = caption.opacity * (1.0 - overlay.help_opacity)
            subtitles.draw(caption._replace(opacity=opacity), picture.rig)
        if dive.tick_source.has_pilot:
            submarine = dive.world.state.submarine
            at_helm = picture.ride is None and not tours.timer.touring
            if at_helm and self.horizon and picture.front_view:
                draw_horizon(picture.front_view)
            self.vignette.update(submarine.rates, submarine.velocity, elapsed_s)
            self.vignette.draw()
            if not self._menu.open:
                now = instrument_reading(submarine, dive.pilot.throttle, dive.pilot.stopping)
                overlay.draw(now, elapsed_s, self.status, not at_helm)
                self._inspector.draw()
            tours.draw()
        else:
            overlay.caption(dive.tick_source.waiting)
        if self._menu.open:
            self._menu.draw(elapsed_s)
        dive.gui.end()

    def message(self, text: str) -> None:
        """Fill the window with one line of text."""
        self._begin()
        self._dive.overlay.message(text)
        self._dive.gui.end()

    @property
    def status(self) -> str:
        """The ridden fish and the state of time, unless normal, in one line."""
        dive, parts = self._dive, []
        if dive.picture.ride is not None:
            ride, colours = dive.picture.ride, dive.picture.colours
            parts.append(ride.text(dive.world, colours, dive.steers_fish))
        if dive.timeline is not None and dive.timeline.text:
            parts.append(dive.timeline.text)
        return "   ".join(parts)

    def _begin(self) -> None:
        """Begin a frame of the gui on the pilot's window."""
        window = self._dive.window
        self._dive.gui.begin(
            window.points, window.size, window.text_scale, self._dive.picture.viewports
        )
