"""Photo mode: time stands still, a free eye looks around, and a lens blurs what is out of focus.

The eye moves as the submarine does, by the same keys and sticks, and keeps as clear of stone and
sand. The blurred picture is the mean light of pictures through points of the lens
(`media.exposure`); one is added with each frame while nothing changes.
"""

from copy import deepcopy
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import msgspec
import numpy as np
from imgui_bundle import imgui

from subsea.base.arrays import Bytes
from subsea.base.language import marked, translated
from subsea.dive.captions import Caption, draw_caption
from subsea.dive.settings import Command, key_words
from subsea.media.exposure import Exposure
from subsea.media.screenshots import pictures_folder
from subsea.rendering.gl.textures import ImageTexture
from subsea.submarine.vessel import step_hull
from subsea.ui.gui import CLAMP, INK, button, colour
from subsea.view.display_rigs import WINDOW_AHEAD_CM
from subsea.view.rig import CameraPose, front, pose_from_angles

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

SAMPLES = 32  # pictures through the lens
WIDEST_CM, NEAREST_CM, FARTHEST_CM = 6.0, 20.0, 2000.0  # of the lens; of the plane in focus
BRIGHTER_EV = 2.0
TURN = 1.2  # rad by a drag over the width of the picture
STEEPEST = 1.4  # rad of pitch
LONGEST = 120  # letters of a caption
SMALLEST_GALLERY = 3.0  # gap around a picture of the gallery, in heights of letters
KINDS = ".png", ".jpg"
WITH_PHOTO: tuple[Command, ...] = (
    "photo", "picture", "menu", "alight", "quality", "fullscreen", "mute", "louder", "quieter",
    "language", "leave",
)  # fmt: skip
"""Commands that work in photo mode; "menu" and "alight" end it."""
REFUSED = marked("no photo mode here: several computers or a headset show this dive")


class LensSettings(NamedTuple):
    """The lens and the exposure that the sliders set."""

    aperture_cm: float = 1.5
    focus_cm: float = 250.0
    brighter_ev: float = 0.0


class PhotoMode:
    """A frozen sea seen by a free eye; `Dive` asks for its eye and its pictures."""

    def __init__(self, dive: "Dive") -> None:
        """Start closed."""
        self._dive = dive
        self.open = False
        self.lens, self.caption = LensSettings(), ""
        self._was_paused = self._gui_was_open = False
        self._taken = 0  # samples
        self._about: object = None  # view, lens and moment of the samples
        self._dragged = True  # the last press of the button began a drag, or was elsewhere
        self._wanted = False  # a picture, as soon as all its samples are taken
        self._gallery: list[Path] = []  # newest first
        self._leaf: int | None = None  # the number of the picture of the gallery that is shown
        self._page: ImageTexture | None = None  # that picture

    def toggle(self) -> None:
        """Open or close it."""
        if self.open:
            self.close()
            return
        dive = self._dive
        time, front_view = dive.timeline, dive.picture.front_view
        if time is None or front_view is None or dive.picture.head is not None:
            dive.overlay.note(translated(REFUSED))
            return
        self._was_paused = time.paused
        if not time.paused:
            time.pause()
        ahead = -front_view.view.view[2, :3].astype(np.float64)
        self._hull = deepcopy(dive.world.state.submarine)
        pitch = float(np.arcsin(np.clip(ahead[2], -1.0, 1.0)))
        self._hull.angles[:] = np.arctan2(ahead[1], ahead[0]), pitch
        self._hull.position[:] = front_view.view.eye - WINDOW_AHEAD_CM * ahead
        self._hull.velocity[:], self._hull.rates[:] = 0.0, 0.0
        dive.ride_fish(None)
        dive.pilot.full_stop()
        self._gui_was_open, dive.gui.open = dive.gui.open, True
        dive.overlay.hide_help()
        self.open = True

    def close(self) -> None:
        """Close it: time goes on, and the eye is that of the submarine again."""
        if not self.open:
            return
        self.open, self._wanted = False, False
        dive = self._dive
        self.release()
        dive.picture.lens = None
        dive.picture.renderer.develop(dive.world.scenario.grade)
        dive.gui.open = self._gui_was_open
        dive.gui.release_all()
        dive.pilot.reset()
        dive.picture.jump()
        if dive.timeline is not None and dive.timeline.paused and not self._was_paused:
            dive.timeline.pause()

    def release(self) -> None:
        """Free its pictures on the GPU."""
        self._close_page()
        self._about = None

    def take(self) -> None:
        """Save the picture, when all its samples are taken."""
        self._wanted = True

    def eye(self, elapsed_s: float) -> CameraPose:
        """The eye `elapsed_s` after the last frame; also gives the picture its lens."""
        dive, hull = self._dive, self._hull
        helm = dive.pilot.commanded(elapsed_s)
        step_hull(hull, helm, min(elapsed_s, 0.1), dive.world.state.sea)
        pose = pose_from_angles(hull.position, *map(float, hull.angles))
        pose = pose._replace(eye=pose.eye + WINDOW_AHEAD_CM * pose.forward)
        picture = dive.picture
        about = (
            *np.round(np.concatenate([pose.eye, pose.forward]), 3).tolist(),
            self.lens.aperture_cm, self.lens.focus_cm, dive.window.size,
            picture.renderer.quality, picture.pattern, dive.world.state.tick,
        )  # fmt: skip
        if about != self._about:
            self._about, self._taken = about, 0
        grade = dive.world.scenario.grade
        brighter = min(max(grade.exposure_ev + self.lens.brighter_ev, -3.0), 3.0)
        picture.renderer.develop(msgspec.structs.replace(grade, exposure_ev=brighter))
        through = Exposure(SAMPLES, 0.0, self.lens.aperture_cm, self.lens.focus_cm)
        picture.lens = None if self.lens.aperture_cm == 0.0 else (through, self._taken)
        return pose

    def expose(self) -> None:
        """Count the drawn sample, and save the picture if it is wanted and complete."""
        samples = 1 if self.lens.aperture_cm == 0.0 else SAMPLES
        self._taken = min(self._taken + 1, samples)
        if self._wanted and self._taken == samples:
            self._wanted = False
            self._save(self._dive.window_set.picture().copy())

    def _save(self, pixels: Bytes) -> None:
        rig = self._dive.picture.rig
        words = Caption(self.caption.strip(), 1.0)
        self._dive.logbook.photographed(pixels)
        self._dive.shots.picture(draw_caption(pixels, rig, front(rig).output, words))

    def draw(self) -> None:
        """Draw the panel or a picture of the gallery in the current frame."""
        size = imgui.get_io().display_size
        if self._page is not None:
            self._draw_page()
            return
        line, flags = imgui.get_font_size(), imgui.WindowFlags_
        imgui.set_next_window_pos((size.x / 2, size.y - 0.8 * line), 0, (0.5, 1.0))
        imgui.begin(
            "photo", None,
            flags.no_title_bar.value | flags.no_move.value | flags.always_auto_resize.value
            | flags.no_saved_settings.value,
        )  # fmt: skip
        self._draw_sliders(line)
        imgui.end()
        if not self._dive.gui.on_panel:
            self._point(size.x)

    def _draw_sliders(self, line: float) -> None:
        lens, values = self.lens, {}
        for name, label, low, high, form, flags in (
            ("aperture_cm", marked("Blur"), 0.0, WIDEST_CM, "%.1f", CLAMP),
            ("focus_cm", marked("Focus"), NEAREST_CM, FARTHEST_CM, "%.0f cm",
             CLAMP | imgui.SliderFlags_.logarithmic.value),
            ("brighter_ev", marked("Brightness"), -BRIGHTER_EV, BRIGHTER_EV, "%+.1f", CLAMP),
        ):  # fmt: skip
            imgui.set_next_item_width(8.0 * line)
            _, values[name] = imgui.slider_float(
                f"{translated(label)}##{name}", getattr(lens, name), low, high, form, flags
            )
            imgui.same_line(0.0, 1.2 * line)
        self.lens = LensSettings(**values)
        imgui.new_line()
        imgui.set_next_item_width(16.0 * line)
        hint = translated(marked("a caption under the picture"))
        _, words = imgui.input_text_with_hint("##caption", hint, self.caption)
        self.caption = words[:LONGEST]
        for text, act, enabled in (
            (marked("Take the picture"), self.take, not self._wanted),
            (marked("Gallery"), self._open_gallery, True),
            (marked("Back to the dive"), self.close, True),
        ):
            imgui.same_line()
            if button(translated(text), enabled):
                self._dive.inspector.later(act)
        inputs = self._dive.pilot.bindings.inputs
        keys = " ".join(key_words(inputs(name)[0]) for name in ("ahead", "left", "astern", "right")
                        if inputs(name))  # fmt: skip
        help_ = translated(marked("{keys}: move. Drag: look around. Click: focus there."))
        imgui.text_disabled(help_.format(keys=keys))

    def _point(self, wide: float) -> None:
        """Turn the eye by a drag over the sea, and focus where the pointer clicks."""
        dragged = imgui.get_mouse_drag_delta(0)
        if imgui.is_mouse_dragging(0):
            angles = self._hull.angles
            angles[0] += TURN * dragged.x / wide
            angles[1] = np.clip(angles[1] + TURN * dragged.y / wide, -STEEPEST, STEEPEST)
            self._hull.previous_angles[:] = angles
            imgui.reset_mouse_drag_delta(0)
            self._dragged = True
        elif imgui.is_mouse_clicked(0):
            self._dragged = False
        elif imgui.is_mouse_released(0) and not self._dragged:
            self._dragged = True
            self._dive.inspector.later(self._focus)

    def _focus(self) -> None:
        """Focus on what is under the pointer."""
        gap = self._dive.picture.depth_at(*self._dive.gui.pointer)
        if gap is not None:
            self.lens = self.lens._replace(focus_cm=min(max(gap, NEAREST_CM), FARTHEST_CM))

    def _open_gallery(self) -> None:
        """Show the newest picture of the folder."""
        folder = pictures_folder(self._dive.preferences.settings.pictures.folder)
        pictures = [path for path in folder.glob("*") if path.suffix in KINDS]
        self._gallery = sorted(pictures, key=lambda path: path.stat().st_mtime, reverse=True)
        if not self._gallery:
            self._dive.overlay.note(translated(marked("no pictures yet")))
            return
        self._turn_page(0)

    def _turn_page(self, leaf: int) -> None:
        """Show a picture of the gallery; a damaged one is left out."""
        from PIL import Image

        if self._page is not None:
            self._page.release()
            self._page = None
        while self._gallery:
            leaf %= len(self._gallery)
            try:
                with Image.open(self._gallery[leaf], formats=("PNG", "JPEG")) as image:
                    self._page = self._dive.picture.upload(np.asarray(image.convert("RGB")))
                    self._side = image.size
            except Exception:  # Pillow's readers raise any exception for damaged files
                del self._gallery[leaf]
                continue
            self._leaf = leaf
            return

    def _close_page(self) -> None:
        if self._page is not None:
            self._page.release()
        self._page = self._leaf = None

    def _draw_page(self) -> None:
        assert self._page is not None and self._leaf is not None
        size, line = imgui.get_io().display_size, imgui.get_font_size()
        gap = SMALLEST_GALLERY * line
        shrunk = min(
            (size.x - 2.0 * gap) / self._side[0], (size.y - 2.0 * gap - 2.0 * line) / self._side[1]
        )
        wide, high = (shrunk * side for side in self._side)
        left, top = (size.x - wide) / 2, gap
        canvas = imgui.get_background_draw_list()
        canvas.add_rect_filled((0.0, 0.0), size, colour((0.0, 0.0, 0.0), 0.85))
        canvas.add_image(imgui.ImTextureRef(self._page.glo), (left, top), (left + wide, top + high))
        flags = imgui.WindowFlags_
        imgui.set_next_window_pos((size.x / 2, size.y - 0.8 * line), 0, (0.5, 1.0))
        imgui.begin(
            "gallery", None,
            flags.no_title_bar.value | flags.no_move.value | flags.always_auto_resize.value
            | flags.no_saved_settings.value,
        )  # fmt: skip
        path, leaf = self._gallery[self._leaf], self._leaf
        imgui.text_colored((*INK, 1.0), f"{leaf + 1} / {len(self._gallery)}   {path.name}")
        for text, act in (
            (marked("Newer"), lambda: self._turn_page(leaf - 1)),
            (marked("Older"), lambda: self._turn_page(leaf + 1)),
            (marked("Close"), self._close_page),
        ):
            imgui.same_line()
            if imgui.button(translated(text)):
                self._dive.inspector.later(act)
        imgui.end()

    @property
    def in_gallery(self) -> bool:
        """True while a picture of the gallery is shown."""
        return self._page is not None

    def back(self) -> None:
        """Return from the gallery, or close."""
        if self.in_gallery:
            self._close_page()
        else:
            self.close()
