"""Draw text, instruments, panels and menu over the pilot's picture."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from imgui_bundle import imgui

from subsea.dive import captions
from subsea.dive.settings import ComfortSettings, Settings
from subsea.frame.diagrams import Label
from subsea.ui.gui import (
    BACKING,
    INK,
    SHADE,
    colour,
    draw_backing,
    fill_with_text,
    ground,
    look,
)
from subsea.ui.hud import (
    Vignette,
    draw_horizon,
    draw_sea_edge,
    edge_reading,
    instrument_reading,
    instruments_area,
)
from subsea.view.front_screen import FrontView, TextViewport
from subsea.view.rig import CameraRig
from subsea.view.theatre_vessel import PANEL_SIZE

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

LARGEST = 99.0  # factor on the size of letters, which the panel then limits
LABEL_SIZE = 0.8  # factor on the size of letters
CLEAR = 7.4  # distance of captions from the lower edge, in heights of letters: above notes
SOFT = tuple(
    (reach * math.cos(k * math.tau / 12), reach * math.sin(k * math.tau / 12), alpha)
    for reach, alpha in ((0.16, 0.05), (0.1, 0.09), (0.05, 0.22))
    for k in range(12)
)  # offsets in heights of letters, and opacities, of a soft shadow
RED = (0.95, 0.15, 0.12)  # while a film is recorded


class TextLayer:
    """Draws one frame of the gui over each picture."""

    def __init__(self, dive: "Dive", settings: Settings) -> None:
        self.vignette = Vignette(settings.comfort.vignette)
        self.horizon = settings.comfort.horizon  # whether to draw one at the helm
        self._dive = dive

    def set_comfort(self, comfort: ComfortSettings) -> None:
        """Follow changed settings."""
        self.vignette.most, self.horizon = comfort.vignette, comfort.horizon

    def draw(self, elapsed_s: float) -> None:
        """Draw one frame, `elapsed_s` after the last.

        Draws nothing over the test pattern, which serves to measure projectors.
        """
        dive, picture, overlay = self._dive, self._dive.picture, self._dive.overlay
        if picture.pattern:
            return
        panel = picture.text_panel
        self._begin(panel)
        if dive.photo.open:
            dive.photo.draw()
            overlay.draw_note(elapsed_s)
            dive.gui.end()
            return
        if panel is None:
            _draw_labels(picture.labels, picture.front_view)
        if not dive.menu.open:  # nor draw a caption behind the help
            caption = dive.subtitle
            opacity = caption.opacity * (1.0 - overlay.covered)
            room = None if panel is not None else picture.rig
            draw_subtitle(caption._replace(opacity=opacity), room)
        if dive.tick_source.has_pilot:
            submarine = dive.world.state.submarine
            at_helm = picture.ride is None and not dive.tours.timer.touring
            tilts = at_helm and not picture.rig.level
            if tilts and self.horizon and picture.front_view and panel is None:
                draw_horizon(picture.front_view, picture.eye.forward)
            self.vignette.update(submarine.rates, submarine.velocity, elapsed_s)
            if picture.head is None and panel is None:
                self.vignette.draw()
            elif picture.head is not None:  # it is drawn around each eye
                self.vignette.most = dive.pilot.settings.comfort.headset_vignette
            if not dive.menu.open:
                now = instrument_reading(submarine, dive.pilot.throttle, dive.pilot.stopping)
                covered = dive.inspector.covers(instruments_area())
                overlay.draw(now, elapsed_s, self.status, not at_helm, covered)
                if at_helm:
                    edge = edge_reading(submarine, dive.world.scenario.bounds)
                    opacity = edge.opacity * (1.0 - overlay.covered)
                    draw_sea_edge(edge._replace(opacity=opacity))
                dive.inspector.draw()
            free = at_helm and not dive.menu.open and not dive.inspector.open
            dive.card.update(elapsed_s, free and overlay.covered == 0.0 and panel is None)
            dive.card.draw()
            dive.touch.draw()
            if not dive.menu.open and not dive.inspector.open and overlay.covered == 0.0:
                dive.introduction.draw()
            dive.tours.draw()
        elif panel is not None:  # other computers show parts of it
            now = instrument_reading(dive.world.state.submarine, 0.0, False)
            overlay.hud.update(now, elapsed_s)
            overlay.hud.draw(now)
        if dive.menu.open:
            dive.menu.draw(elapsed_s)
        if dive.shots.filming:
            _draw_film_mark(dive.shots.seconds)
        dive.gui.end()

    def message(self, text: str) -> None:
        """Fill the window with one line of text."""
        self._begin()
        fill_with_text(text)
        self._dive.gui.end()

    @property
    def status(self) -> str:
        """The ridden fish and the state of time, unless normal, in one line."""
        dive, parts = self._dive, []
        if dive.picture.ride is not None:
            ride, colours = dive.picture.ride, dive.picture.colours
            parts.append(ride.text(dive.world, colours, dive.steers_fish, dive.kiosk))
        if dive.timeline is not None and dive.timeline.text:
            parts.append(dive.timeline.text)
        return "   ".join(parts)

    def _begin(self, panel: TextViewport | None = None) -> None:
        """Begin a frame, on the vessel's panel or on the window."""
        window, gui = self._dive.window, self._dive.gui
        if panel is not None:
            gui.begin(window.points, PANEL_SIZE, LARGEST, (panel,))
        else:
            gui.begin(window.points, window.size, window.text_scale, self._dive.picture.viewports)


def _draw_film_mark(seconds: float) -> None:
    """Draw a red dot and the length of the film in the upper right corner, over panels too."""
    size, line = imgui.get_io().display_size, imgui.get_font_size()
    canvas, text = imgui.get_foreground_draw_list(), f"{seconds // 60:.0f}:{int(seconds) % 60:02d}"
    wide = imgui.calc_text_size(text).x
    left, top = size.x - wide - 2.4 * line, 0.8 * line
    low, high = (left - 0.5 * line, top - 0.2 * line), (size.x - 0.7 * line, top + 1.2 * line)
    canvas.add_rect_filled(low, high, colour(SHADE, ground(BACKING)), 0.35 * line)
    canvas.add_circle_filled((left + 0.4 * line, top + 0.5 * line), 0.4 * line, colour(RED))
    canvas.add_text((left + 1.2 * line, top), colour(INK), text)


def _draw_labels(labels: Sequence[Label], front_view: FrontView | None) -> None:
    """Draw labels on a flat screen ahead; for two eyes where the left one sees them."""
    if front_view is None or not labels:
        return
    size, font = imgui.get_io().display_size, imgui.get_font()
    tall = LABEL_SIZE * imgui.get_font_size()
    canvas = imgui.get_background_draw_list()
    places = front_view.places(np.array([label.place for label in labels]))
    for (x, y), label in zip(places.tolist(), labels, strict=True):
        if not (0.0 <= x <= 1.0 and 0.0 <= y <= 1.0):  # NaN behind the viewer
            continue
        wide = LABEL_SIZE * imgui.calc_text_size(label.text).x
        left, top = x * size.x - wide / 2, y * size.y - tall
        for off, ink in ((1.0, colour(SHADE, 0.8)), (0.0, colour(INK, 0.95))):
            canvas.add_text(font, tall, (left + off, top + off), ink, label.text)


def draw_subtitle(caption: captions.Caption, rig: CameraRig | None) -> None:
    """Draw a caption near the foot of the picture of a rig; None: of all of the gui's screen."""
    if caption.opacity == 0.0 or not caption.words:
        return
    size = imgui.get_io().display_size
    left, top, across, down = (0.0, 0.0, 1.0, 1.0) if rig is None else captions.room_of(rig)
    left, top, width, height = left * size.x, top * size.y, across * size.x, down * size.y
    tall = captions.letters_of(width, height) * look().text
    foot = min(top + captions.FOOT * height, size.y - CLEAR * imgui.get_font_size())
    canvas = imgui.get_background_draw_list()
    imgui.push_font(None, tall)
    lines = captions.lines_of(
        caption.words, captions.ROOM * width, lambda line: imgui.calc_text_size(line).x
    )
    box = imgui.calc_text_size("x").y
    wide = max((imgui.calc_text_size(line).x for line in lines), default=0.0)
    begin, top = left + (width - wide) / 2, foot - (len(lines) - 1) * captions.LEADING * tall - box
    draw_backing((begin, top), (begin + wide, foot), tall, caption.opacity)
    for k, line in enumerate(reversed(lines)):
        x = left + (width - imgui.calc_text_size(line).x) / 2
        y = foot - k * captions.LEADING * tall - box
        for aside, below, alpha in SOFT:
            shade = colour(captions.SHADE, alpha * caption.opacity)
            canvas.add_text((x + aside * tall, y + below * tall), shade, line)
        canvas.add_text((x, y), colour(captions.INK, caption.opacity), line)
    imgui.pop_font()
