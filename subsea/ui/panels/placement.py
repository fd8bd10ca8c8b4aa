"""Placement (Tu §9.1): positions of things, by dragging in the view or by numbers.

While it is open, a click in the sea chooses the thing under the pointer, and a drag moves it; then
a new world is made, and this one goes on until that is there.
"""

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from imgui_bundle import imgui
from msgspec.structs import replace

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.fish.species import species_names
from subsea.scenario.schema import Scenario
from subsea.state import Sea
from subsea.submarine.vessel import paths_of
from subsea.ui.gui import GLASS, MARK, REFUSED, WARM, button, colour, wrapped_text
from subsea.ui.panels import fields
from subsea.ui.panels.fields import Area, PanelContext
from subsea.ui.undo import History
from subsea.view.front_screen import FrontView
from subsea.world import placement
from subsea.world.checks import check_in_sea, tour_fault, with_solids
from subsea.world.placement import Grip, Handle
from subsea.world.world import World

AWAY = "Move things away from its line, or give it another one later."
WIDE, ROWS = 20.0, 7.5  # of the list, in heights of letters
BIGGER, TURN_DEG = 1.08, 5.0  # of a step of the wheel
HIGHER = 3.0  # a drag over the height of the screen scales by exp(HIGHER)
REST_S = 0.5  # from the wheel's last step until the world changes
NEAR_CM = 60.0  # nearer things are not picked: the eye is inside


@dataclass
class PlacementState:
    """The state of the panel: history, choice and drag."""

    history: History[Scenario] | None = None
    chosen: tuple[str, int] | None = None  # kind and number of a thing
    held: Grip | None = None  # while it is dragged
    begun: tuple[float, float] = (0.0, 0.0)  # start of the drag on the screen
    trial: Scenario | None = None  # scenario if the drag ended now
    fault: str = ""  # error of the trial
    misfit: str = ""  # warning of an accepted move after which a tour no longer fits
    toured: tuple[Scenario, Sea] | None = None  # for which `misfit` was found
    rest_s: float = 0.0  # time left after the wheel has turned
    message: str = ""  # error of the last change
    seen: tuple[Scenario, Sea, list[Handle]] | None = None  # cache of `things`
    frame: int = 0  # of the last drawing

    def things(self, now: Scenario, scenario: Scenario, world: World) -> list[Handle]:
        """All things that can be placed: schools where they are, the others cached.

        `now` is the scenario of the world, and `scenario` that of the trial, if any.
        """
        sea = world.state.sea
        if not self.seen or self.seen[0] is not scenario or self.seen[1] is not sea:
            handles = placement.handles(scenario, sea)
            self.seen = scenario, sea, [handle for handle in handles if handle.kind != "fish"]
        submarine, *others = self.seen[2]
        return [submarine, *placement.schools(now, scenario, world.state.fishes, sea), *others]

    def warn(self, scenario: Scenario, sea: Sea) -> str:
        """Return a warning if a tour does not fit a scenario, else an empty text; cached.

        The fault names waypoints, which are in the file and not in the view.
        """
        if not self.toured or self.toured[0] is not scenario or self.toured[1] is not sea:
            fault = tour_fault(scenario, *with_solids(scenario, sea), stored=False)
            self.toured, self.misfit = (scenario, sea), ""
            if fault and fault.key:
                tour = scenario.tour[int(fault.key.strip("tour[]"))]
                self.misfit = f"The tour {tour.name!r}, drawn in the sea, passes too near. {AWAY}"
        return self.misfit

    def try_out(self, scenario: Scenario, sea: Sea, source: str) -> None:
        """Try a scenario, and check it."""
        self.trial, self.fault = scenario, ""
        try:
            check_in_sea(scenario, sea)
        except UserError as fault:
            self.fault = f"{source}: {fault}"

    def reset_trial(self) -> None:
        """End a trial."""
        self.trial, self.held, self.fault, self.rest_s = None, None, "", 0.0


def panel(context: PanelContext) -> None:
    """Draw the panel, and drag things in the sea."""
    placing, dive = context.state(PlacementState), context.dive
    if placing.history is None or (
        placing.history.present is not dive.scenario and not dive.changing
    ):
        placing.history, placing.chosen = History(dive.scenario), None
        placing.reset_trial()
    frame = imgui.get_frame_count()
    if frame > placing.frame + 1 and not dive.changing:  # the panel was hidden during a drag
        placing.reset_trial()
    placing.frame = frame
    sea, scenario = dive.world.state.sea, placing.trial or dive.scenario
    things = placing.things(dive.scenario, scenario, dive.world)
    _list(placing, scenario, things)
    _buttons(context, placing)
    _numbers(context, placing, scenario, sea)
    message = placing.fault or placing.message
    if message:
        wrapped_text(message, REFUSED, WIDE)
    misfit = placing.warn(scenario, sea)
    if misfit:
        wrapped_text(misfit, WARM, WIDE)
    front_view = dive.picture.front_view
    if front_view is None:
        imgui.text_disabled("Things are dragged in flat pictures.")
        return
    within = [thing for thing in things if math.dist(thing.place, front_view.view.eye) > NEAR_CM]
    over = _drag(context, placing, front_view, within)
    if misfit:
        _draw_lines(front_view, paths_of(scenario), WARM, 0.08, many=True)
    for thing in within:
        if (thing.kind, thing.number) == placing.chosen:
            context.subject = placing.chosen, _box(front_view, thing)
            _show(front_view, thing, REFUSED if placing.fault else MARK, 0.1)
        elif thing is over:
            _show(front_view, thing, MARK, 0.05)


def name_of(scenario: Scenario, kind: str, number: int) -> str:
    """A thing as a text: its kind and number."""
    words = placement.KINDS[kind]
    if kind in placement.SINGLE:
        return words
    entry = getattr(scenario, kind)[number]
    what = f"{entry.number} {entry.species}" if kind == "fish" else getattr(entry, "kind", "")
    more = f": {what.replace('_', ' ')}" if what else ""
    return f"{words.split(' ', 1)[-1]} {number + 1}{more}"


def apply_placement(context: PanelContext, scenario: Scenario) -> bool:
    """Continue the dive with a changed scenario; False, with a note, if it has a fault."""
    placing, dive = context.state(PlacementState), context.dive
    placing.reset_trial()
    placing.message = ""
    if scenario == dive.scenario:
        return True
    placing.trial = scenario  # shown in lines until its world is there
    entered = _enter(context, scenario)
    placing.reset_trial()
    if not entered:
        return False
    assert placing.history is not None
    placing.history.do(dive.scenario)
    return True


def undo(context: PanelContext, forth: bool = False) -> bool:
    """Undo the last change, or with `forth` redo it; False without one."""
    history = context.state(PlacementState).history
    if history is None or not (history.may_redo if forth else history.may_undo):
        return False
    context.state(PlacementState).reset_trial()
    scenario = history.redo() if forth else history.undo()
    if not _enter(context, scenario):
        _ = history.undo() if forth else history.redo()
        return False
    return True


def _enter(context: PanelContext, scenario: Scenario) -> bool:
    placing, dive = context.state(PlacementState), context.dive
    try:
        entered = dive.change_world(scenario)
    except UserError as fault:
        placing.message = str(fault)
        dive.note(placing.message)
        return False
    placing.message = ""
    return entered


def _list(placing: PlacementState, scenario: Scenario, things: list[Handle]) -> None:
    line = imgui.get_font_size()
    if imgui.begin_list_box("##things", (WIDE * line, ROWS * line)):
        for thing in things:
            which = thing.kind, thing.number
            if imgui.selectable(name_of(scenario, *which), which == placing.chosen)[0]:
                placing.chosen = which
        imgui.end_list_box()


def _buttons(context: PanelContext, placing: PlacementState) -> None:
    """Buttons to add, remove, undo and redo, with the usual keys."""
    history, chosen, dive = placing.history, placing.chosen, context.dive
    assert history is not None
    if imgui.button("Add"):
        imgui.open_popup("add")
    if imgui.begin_popup("add"):
        for kind, words in placement.KINDS.items():
            if kind != "submarine" and imgui.selectable(words, False)[0]:
                context.later(partial(_add, context, kind))
        imgui.end_popup()
    imgui.same_line()
    if button("Remove", chosen is not None) and chosen is not None:
        context.later(partial(_remove, context, *chosen))
    typing = imgui.get_io().want_text_input
    ctrl = imgui.Key.mod_ctrl.value
    for words, letter, key, forth, may in (
        ("Undo", "Z", imgui.Key.z, False, history.may_undo),
        ("Redo", "Y", imgui.Key.y, True, history.may_redo),
    ):
        imgui.same_line()
        pressed = button(words, may)
        imgui.set_item_tooltip(f"Ctrl+{letter}")
        if (pressed or (imgui.is_key_chord_pressed(ctrl | key.value) and not typing)) and may:
            context.later(partial(undo, context, forth))
    if dive.picture.front_view is not None:
        imgui.text_disabled("Drag in the sea. Shift: height, or near and far.")
        imgui.text_disabled("Wheel: size. Ctrl and wheel: turn.")


def _add(context: PanelContext, kind: str) -> None:
    dive, placing = context.dive, context.state(PlacementState)
    front_view, sea = dive.picture.front_view, dive.world.state.sea
    submarine = dive.world.state.submarine
    if front_view is None:
        heading = float(submarine.angles[0])
        way = np.array([math.cos(heading), math.sin(heading), -0.3])
        eye = submarine.position
    else:
        eye, way = front_view.ray(0.5, 0.6)
    at = placement.place_ahead(sea, eye, way)
    if apply_placement(context, placement.added(dive.scenario, kind, at, sea)):
        entries = getattr(dive.scenario, kind)
        placing.chosen = kind, 0 if kind in placement.SINGLE else len(entries) - 1


def _remove(context: PanelContext, kind: str, number: int) -> None:
    placing, dive = context.state(PlacementState), context.dive
    things = placement.handles(dive.scenario, dive.world.state.sea)
    for thing in things:
        if (thing.kind, thing.number) == (kind, number):
            try:
                remaining = placement.removed(dive.scenario, thing)
            except UserError as fault:
                placing.message = str(fault)
                dive.note(placing.message)
                return
            if apply_placement(context, remaining):
                placing.chosen = None
            return


def _numbers(context: PanelContext, placing: PlacementState, scenario: Scenario, sea: Sea) -> None:
    if placing.chosen is None:
        return
    kind, number = placing.chosen
    entry = placement.table_of(scenario, kind, number)
    if entry is None:
        placing.chosen = None
        return
    imgui.separator_text(name_of(scenario, kind, number))
    imgui.push_id(f"{kind} {number}")
    new, settled = entry, False
    if kind == "fish":
        species = fields.choice("species", entry.species, species_names())
        new, settled = replace(new, species=species.value), species.settled
    new, entered = fields.table(new)
    imgui.pop_id()
    if new != entry:
        changed = placement.with_table(scenario, kind, number, new)
        placing.try_out(changed, sea, str(context.dive.source))
    if (settled or entered) and placing.trial is not None:
        context.later(partial(apply_placement, context, placing.trial))


def _drag(
    context: PanelContext, placing: PlacementState, front_view: FrontView, things: list[Handle]
) -> Handle | None:
    """Drag things with the pointer; returns the thing under it."""
    dive, io = context.dive, imgui.get_io()
    sea, source, pointer = dive.world.state.sea, str(dive.source), dive.gui.pointer
    over = None
    if dive.changing:
        return over
    if placing.held is None and not dive.gui.on_panel:
        over = placement.pick(things, sea, *front_view.ray(*pointer))
        if imgui.is_mouse_clicked(0) and over is not None:
            placing.chosen, context.dragging = (over.kind, over.number), True
            placing.held, placing.begun = placement.grip(over, *front_view.ray(*pointer)), pointer
            placing.message = ""
        _turn_wheel(context, placing, things)
    held = placing.held
    if held is None:
        return over
    if imgui.is_mouse_released(0) or not imgui.is_mouse_down(0):
        placing.held = None
        if placing.trial is not None:
            _drop(context, placing)
        return over
    if imgui.is_mouse_dragging(0):
        now = dive.scenario
        if io.key_shift and held.handle.kind not in placement.FREE:
            up = HIGHER * (placing.begun[1] - pointer[1])
            new: Scenario | None = placement.raised(now, held.handle, math.exp(up))
        else:
            at = placement.aim(held, sea, *front_view.ray(*pointer), level=io.key_shift)
            new = None if at is None else placement.moved(now, held.handle, at)
        if new is not None and new != placing.trial:
            placing.try_out(new, sea, source)
    return held.handle


def _turn_wheel(context: PanelContext, placing: PlacementState, things: list[Handle]) -> None:
    """Resize the chosen thing with the wheel, or turn it with Ctrl."""
    io, dive = imgui.get_io(), context.dive
    chosen = [thing for thing in things if (thing.kind, thing.number) == placing.chosen]
    if io.mouse_wheel and chosen:
        before = placing.trial or dive.scenario
        if io.key_ctrl:
            new = placement.turned(before, chosen[0], TURN_DEG * io.mouse_wheel)
        else:
            new = placement.resized(before, chosen[0], BIGGER**io.mouse_wheel)
        placing.try_out(new, dive.world.state.sea, str(dive.source))
        placing.rest_s = REST_S
    elif placing.rest_s > 0.0:
        placing.rest_s -= io.delta_time
        if placing.rest_s <= 0.0 and placing.trial is not None:
            _drop(context, placing)


def _drop(context: PanelContext, placing: PlacementState) -> None:
    """Apply the trial, or report its error."""
    if placing.fault:
        placing.message = placing.fault
        context.dive.note(placing.message)
        placing.reset_trial()
    elif placing.trial is not None:
        context.later(partial(apply_placement, context, placing.trial))


def _box(front_view: FrontView, thing: Handle) -> Area | None:
    """The part of the screen in which a thing is seen; None where it is not."""
    size = imgui.get_io().display_size
    lines = front_view.lines(thing.outline).reshape(-1, 2)
    if not len(lines):
        return None
    (left, top), (right, low) = (np.clip(f(axis=0), 0.0, 1.0) for f in (lines.min, lines.max))
    return left * size.x, top * size.y, (right - left) * size.x, (low - top) * size.y


def _show(
    front_view: FrontView, thing: Handle, ink: tuple[float, float, float], wide: float
) -> None:
    """Draw the outline of a thing, under all panels."""
    _draw_lines(front_view, thing.outline, ink, wide, many=len(thing.body) > 1)


def _draw_lines(
    front_view: FrontView, given: Array, ink: tuple[float, float, float], wide: float, many: bool
) -> None:
    """Draw lines (n, 2, 3) of the sea, thin ones if they are `many`."""
    size, line = imgui.get_io().display_size, imgui.get_font_size()
    canvas = imgui.get_background_draw_list()
    lines = front_view.lines(given) * (size.x, size.y)
    if not len(lines):
        return
    tint, wide = colour(ink, 0.95), max((0.5 if many else 1.0) * wide * line, 1.2)
    # One call for each run of connected lines.
    ends = np.flatnonzero((lines[1:, 0] != lines[:-1, 1]).any(axis=1)) + 1
    for curve in np.split(lines, ends):
        points: list[Any] = [
            imgui.ImVec2(*point) for point in [*curve[:, 0].tolist(), curve[-1, 1].tolist()]
        ]
        if not many:
            canvas.add_polyline(points, colour(GLASS, 0.45), wide + 1.5, 0)
        canvas.add_polyline(points, tint, wide, 0)
