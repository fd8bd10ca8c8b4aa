"""Panels of a species: its numbers, the options of the views, and the swimming preview.

A dragged or typed number is shown at once and recorded when it is released. An invalid one is
refused with a message in the status line.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import msgspec
import numpy as np
from imgui_bundle import imgui

from subsea.biomechanics.body_plan import MODEL_LENGTHS, NODES_AT_STATION
from subsea.fish.raster import from_srgb, to_srgb
from subsea.fish.swimmer import MODES
from subsea.studio.builder.views import RINGS, OutlineViews, PhotoOverlay
from subsea.studio.checks import displaced_cm3
from subsea.studio.draft import EditState, KeyPath, SpeciesDraft, value_at, with_value
from subsea.studio.handles import FINS, PAIRED_FINS, DragHandle, View, drag_handle, handles
from subsea.studio.outline import with_fin, with_length, with_mass
from subsea.studio.preview_panel import PreviewPanel
from subsea.studio.tool_window import ToolWindow
from subsea.ui.gui import CLAMP, GLASS, QUIET, button, wrapped_text

MODE_WIDTH = 3.9  # of a button of a swimming mode, text heights


def draw_view_options(
    views: OutlineViews,
    editing: EditState,
    overlay: PhotoOverlay | None,
    remove_point: Callable[[], None],
) -> None:
    """Draw the options of the views, and the buttons that add and remove points."""
    _, views.outline = imgui.checkbox("Outline", views.outline)
    imgui.same_line()
    _, views.scaffold = imgui.checkbox("Scaffold", views.scaffold)
    imgui.same_line()
    _, views.soft = imgui.checkbox("Soft", views.soft)
    imgui.set_item_tooltip("Points beside the one that is dragged go along")
    imgui.same_line()
    if imgui.button("Add point" if not views.adding else "Click on a line…"):
        views.adding = not views.adding
    imgui.same_line()
    if button("Take away", editing.selected is not None):
        remove_point()
    imgui.same_line()
    if imgui.button("Fit"):
        views.fit()
    if overlay:
        imgui.same_line()
        overlay.draw_options()


def draw_preview(preview: PreviewPanel, window: ToolWindow, elapsed_s: float) -> None:
    """Draw the fish, and the choice of how it swims."""
    (width, height), line = room(), window.text_height
    scale = window.window.size[0] / window.window.points[0]
    preview.draw((max(width, 8), max(height - 1.9 * line, 8)), scale, elapsed_s)
    swimmer = preview.swimmer
    modes = MODES if swimmer.can_turn else MODES[:4]
    if width < MODE_WIDTH * line * len(modes):
        imgui.set_next_item_width(width)
        _, number = imgui.combo("##way", modes.index(swimmer.mode), list(modes))
        swimmer.mode = modes[number]
        return
    for number, mode in enumerate(modes):
        if number:
            imgui.same_line()
        if imgui.radio_button(mode.capitalize(), swimmer.mode == mode):
            swimmer.mode = mode


def room() -> tuple[float, float]:
    """Return the free width and height of the present panel, in points."""
    free = imgui.get_content_region_avail()
    return free.x, free.y


KINDS = ("pacifist", "prey", "predator")
KIND_WORDS = "pacifist: harmless, courts", "prey: flees and schools", "predator: hunts"
COUPLINGS = ("sections", "patches", "tetrahedra")
ROWS = ("nose", "ring 1", "ring 2", "ring 3", "ring 4", "ring 5", "tail tips")
NAMES_LONG = 60  # characters at most


class NumberPanels:
    """Tabs of numbers; `hovered` is the ring whose row is under the pointer."""

    def __init__(self) -> None:
        self.show = ""  # the tab to open in the next frame
        self.hovered: KeyPath | None = None
        self._text: dict[KeyPath, str] = {}  # being typed

    def draw(self, editing: EditState) -> None:
        """Draw the tabs, except Checks, into the present tab bar."""
        self.hovered = None
        imgui.get_style().set_color_(imgui.Col_.table_header_bg.value, (*GLASS, 1.0))
        muscular = bool(editing.present.species.muscles)
        for name, panel in (
            ("Shape", self._shape), ("Body", self._body), ("Motion", self._motion),
            ("Colours", self._colours), ("Names", self._names),
        ):  # fmt: skip
            if imgui.begin_tab_item(name, None, self.tab_flags(name))[0]:
                imgui.begin_child(f"##{name}")
                if muscular or panel not in (self._body, self._motion):
                    panel(editing)
                else:
                    wrapped_text(
                        "Its spine moves this fish, not muscles. Its motion is in the table "
                        "[spine] of its file (docs/reference/spine-table.md), which stays as it "
                        "is. Outline, fins, colours and names can be changed here."
                    )
                imgui.end_child()
                imgui.end_tab_item()
        self.show = ""

    def tab_flags(self, name: str) -> int:
        """Return the flags that open the tab now, if it was asked for."""
        return imgui.TabItemFlags_.set_selected.value if self.show == name else 0

    def _shape(self, editing: EditState) -> None:
        imgui.separator_text("Chosen point")
        path = editing.selected
        sides: tuple[View, ...] = ("side", "top")
        found = [
            (view, handle)
            for view in sides
            for handle in handles(editing.present, view)
            if handle.path == path
        ]
        for number, (view, handle) in enumerate(found):
            _handle(editing, view, handle, (0, 1) if number == 0 else (1,))
        if not found:
            imgui.text_disabled("none: click one in a view")
        imgui.separator_text("Fins")
        for name in (*FINS, *PAIRED_FINS):
            there = bool(editing.present.content["surface"].get(name))
            changed, now = imgui.checkbox(f"{name} fin{'s' if name in PAIRED_FINS else ''}", there)
            if changed:
                editing.do(partial(with_fin, name=name, there=now))
            elif there and name in PAIRED_FINS:
                for key, low, high, step in (
                    ("length", 0.01, 1.0, 0.002), ("width", 0.005, 1.0, 0.002),
                    ("droop", -90.0, 90.0, 0.5),
                ):  # fmt: skip
                    _number(editing, ("surface", name, key), f"{key}##{name}", low, high, step)
                _tick(editing, ("surface", name, "wing"), f"held out stiffly##{name}")
        _tick(editing, ("surface", "stiff_fins"), "stiff dorsal, ventral and tail fins")
        imgui.separator_text("Eye and skin")
        _number(editing, ("surface", "eye", "radius"), "radius of the eye", 0.002, 0.2, 0.0005)
        _choice(editing, ("surface", "coupling"), "skin hangs by", COUPLINGS, COUPLINGS)

    def _body(self, editing: EditState) -> None:
        draft = editing.present
        body = draft.content["body"]
        imgui.separator_text("Scaffold, cm, and grams on each node")
        if _begin_table("##rings", "", "behind", "wide", "high", "mass"):
            for row, name in enumerate(ROWS):
                imgui.table_next_row()
                imgui.table_next_column()
                ink = RINGS[row - 1] if row else QUIET
                imgui.text_colored((*ink, 1.0), name)
                self._ring_cells(editing, row, body)
                ring = ("body", "ring", row - 1)
                low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
                if row and imgui.is_window_hovered():
                    y = imgui.get_mouse_pos().y
                    if low.y <= y <= high.y:
                        self.hovered = ring
            imgui.end_table()
        water = displaced_cm3(draft.species)
        weight = sum(m * n for m, n in zip(body["masses"], NODES_AT_STATION, strict=True))
        imgui.text(f"{weight:.0f} g in all; the body displaces {water:.0f} g of water")
        if imgui.button("Neutral"):
            editing.do(lambda d: with_mass(d, displaced_cm3(d.species)))
        imgui.set_item_tooltip("Masses in proportion, as heavy as the water displaced")
        imgui.same_line()
        imgui.set_next_item_width(6.0 * imgui.get_font_size())
        long = body["stations"][-1]
        changed, new = imgui.drag_float(
            "length of the model, cm", long, 0.1, *MODEL_LENGTHS, "%.2f"
        )
        if changed and new > 1.0:
            editing.drag(lambda d: with_length(d, new))
        _commit_after(editing)
        imgui.separator_text("Units")
        for key, words, step in (
            ("muscle_stiffness", "muscles, g/tu²", 1.0),
            ("cross_stiffness", "cross units, g/tu²", 1.0),
            ("other_stiffness", "other units, g/tu²", 1.0),
            ("viscosity", "viscosity, g/tu", 0.002),
            ("water_drag", "drag of the water, g/cm³", 0.01),
        ):  # fmt: skip
            _number(editing, ("body", key), words, 0.001, 1e5, step, "%.4g")

    def _ring_cells(self, editing: EditState, row: int, body: dict[str, Any]) -> None:
        imgui.table_next_column()
        if 1 <= row <= 5:
            _cell(editing, ("body", "stations", row), 0.02)
        else:
            imgui.text_disabled(f"{body['stations'][row]:.2f}")
        for key in ("half_widths", "half_heights"):
            imgui.table_next_column()
            if 1 <= row <= 5:
                _cell(editing, ("body", key, row - 1), 0.01)
            elif row == 6 and key == "half_heights":
                _cell(editing, ("body", "tail_half_height"), 0.01)
        imgui.table_next_column()
        _cell(editing, ("body", "masses", row), 0.02)

    def _motion(self, editing: EditState) -> None:
        imgui.separator_text("Swimming")
        _number(editing, ("swim", "ticks_per_beat"), "ticks a beat", 4, 60, 0.1, whole=True)
        for k, part in enumerate(("anterior", "posterior")):
            _number(editing, ("swim", "contraction", k), f"contraction, {part}", 0.0, 0.6, 0.002)
        _number(editing, ("swim", "lag"), "lag of the posterior, rad", 0.0, 3.2, 0.01)
        _number(editing, ("swim", "slow"), "slow, over fast", 0.01, 0.99, 0.005)
        _number(editing, ("swim", "medium"), "medium, over fast", 0.01, 0.99, 0.005)
        imgui.separator_text("Turning")
        for k, part in enumerate(("anterior", "posterior")):
            _number(editing, ("turn", "gradual", k), f"gradual, {part}", 0.0, 0.6, 0.001)
        _number(editing, ("turn", "sharp"), "sharp turn, degrees", 1.0, 90.0, 0.5, "%.1f")
        _number(editing, ("turn", "amplitude"), "beat in it, over fast", 0.0, 1.0, 0.005)
        imgui.separator_text("Steering map")
        if _begin_table("##map", "angle", "anterior", "posterior", "bend", "hold", "restore"):
            for row in range(len(editing.present.content["turn"]["steering"])):
                at: KeyPath = ("turn", "steering", row)
                imgui.table_next_row()
                for path, step in (
                    ((*at, "angle"), 0.5), ((*at, "contraction", 0), 0.001),
                    ((*at, "contraction", 1), 0.001), ((*at, "bend_ticks"), 0.1),
                    ((*at, "hold_ticks"), 0.1), ((*at, "restore_ticks"), 0.1),
                ):  # fmt: skip
                    imgui.table_next_column()
                    _cell(editing, path, step)
            imgui.end_table()

    def _colours(self, editing: EditState) -> None:
        skin = editing.present.content["skin"]
        if "sheet" in skin:
            wrapped_text(
                "This species has a skin from a photograph. Without it, these colours are painted:"
            )
            if imgui.button("Take the picture off"):
                editing.do(partial(with_value, path=("skin", "sheet"), value=None))
        wrapped_text("Click a colour to change it.")
        for path in _coloured(skin):
            value = to_srgb(np.array(value_at(editing.present, ("skin", *path)))).tolist()
            flags = imgui.ColorEditFlags_.float.value | imgui.ColorEditFlags_.no_inputs.value
            changed, new = imgui.color_edit3(_colour_name(path), value, flags)
            if changed:
                linear = from_srgb(np.array(new)).round(4).tolist()
                at: KeyPath = ("skin", *path)
                editing.drag(partial(with_value, path=at, value=linear))
            _commit_after(editing)
        imgui.separator_text("Shine")
        for key in ("gloss", "silver", "scales", "rays", "blotches", "clear_back", "pupil"):
            _number(editing, ("skin", key), key.replace("_", " "), 0.0, 1.0, 0.005)
        wrapped_text(
            "Stripes, patches and spots are written in the file: docs/reference/species.md."
        )

    def _names(self, editing: EditState) -> None:
        for key, words in (("name", "name"), ("scientific_name", "scientific name")):
            path: KeyPath = (key,)
            value = self._text.get(path, str(editing.present.content[key]))
            imgui.set_next_item_width(16.0 * imgui.get_font_size())
            changed, text = imgui.input_text(words, value)
            if changed:
                self._text[path] = text[:NAMES_LONG]
            if imgui.is_item_deactivated_after_edit() and path in self._text:
                typed = self._text.pop(path).strip()
                editing.do(partial(with_value, path=path, value=typed))
        _choice(editing, ("kind",), "kind", KINDS, KIND_WORDS)
        _tick(editing, ("schooling",), "it swims in schools")
        for k, words in enumerate(("smallest adult, cm", "largest adult, cm")):
            _number(editing, ("size_cm", k), words, 2.0, 300.0, 0.2, "%.1f")


def _handle(editing: EditState, view: View, handle: DragHandle, axes: tuple[int, ...]) -> None:
    for axis in axes:
        words = "behind the snout" if axis == 0 else "aside" if view == "top" else "up"
        imgui.set_next_item_width(7.0 * imgui.get_font_size())
        changed, new = imgui.drag_float(
            f"{words}, lengths##{view}", handle.at[axis], 0.001, -1.0, 1.0, "%.4f"
        )
        if changed:
            to = (new, handle.at[1]) if axis == 0 else (handle.at[0], new)
            editing.drag(partial(drag_handle, view=view, path=handle.path, to=to))
        _commit_after(editing)


def _begin_table(name: str, *columns: str) -> bool:
    """Begin a table with a row of headers; returns True if it is visible."""
    visible = imgui.begin_table(name, len(columns), imgui.TableFlags_.sizing_stretch_same.value)
    if visible:
        for column in columns:
            imgui.table_setup_column(column)
        imgui.table_headers_row()
    return bool(visible)


def _commit_after(editing: EditState) -> None:
    """Record a drag when it ends."""
    if imgui.is_item_deactivated():
        editing.commit()


def _value(draft: SpeciesDraft, path: KeyPath) -> Any:
    """Return a value of the species, also if the file leaves it out."""
    here: Any = msgspec.to_builtins(draft.species)
    for step in path:
        here = here[step]
    return here


def _number(
    editing: EditState, path: KeyPath, words: str, low: float, high: float, step: float,
    form: str = "%.4g", whole: bool = False,
) -> None:  # fmt: skip
    imgui.set_next_item_width(7.0 * imgui.get_font_size())
    _drag(editing, path, words, low, high, step, "%.0f" if whole else form, whole)


def _cell(editing: EditState, path: KeyPath, step: float) -> None:
    imgui.set_next_item_width(-1.0)
    name = ".".join(map(str, path))
    _drag(editing, path, f"##{name}", 0.0, 1e4, step, "%.3f", False)


def _drag(
    editing: EditState, path: KeyPath, words: str, low: float, high: float, step: float, form: str,
    whole: bool,
) -> None:  # fmt: skip
    value = _value(editing.present, path)
    changed, new = imgui.drag_float(words, float(value), step, low, high, form, CLAMP)
    if changed:
        short: float = round(new) if whole else float(f"{new:.4g}")
        if short != value:
            editing.drag(lambda d: with_value(d, path, short))
    _commit_after(editing)


def _tick(editing: EditState, path: KeyPath, words: str) -> None:
    changed, now = imgui.checkbox(words, bool(_value(editing.present, path)))
    if changed:
        editing.do(lambda d: with_value(d, path, now))


def _choice(
    editing: EditState, path: KeyPath, words: str, values: tuple[str, ...], shown: tuple[str, ...]
) -> None:
    imgui.set_next_item_width(14.0 * imgui.get_font_size())
    now = values.index(_value(editing.present, path))
    changed, number = imgui.combo(words, now, list(shown))
    if changed:
        editing.do(lambda d: with_value(d, path, values[number]))


def _coloured(skin: dict[str, Any]) -> list[KeyPath]:
    """Return the paths of the colours of a skin, in the order of its file, plain ones first."""
    plain: list[KeyPath] = [(key,) for key in ("back", "flank", "belly", "iris") if key in skin]
    for key, value in skin.items():
        rows = (
            value if isinstance(value, list) and value and isinstance(value[0], dict) else [value]
        )
        for k, row in enumerate(rows):
            if isinstance(row, dict):
                at: KeyPath = (key, k) if row is not value else (key,)
                plain += [(*at, name) for name in ("colour", "rim", "of", "to") if name in row]
    return plain


def _colour_name(path: KeyPath) -> str:
    """Return a label: patches count from 1, and `display` is for courting males."""
    steps = [str(step + 1) if isinstance(step, int) else step for step in path]
    words = " ".join(step for step in steps if step != "colour").replace("patches", "patch")
    return words.replace("display of", "courting, from").replace("display to", "courting, to")
