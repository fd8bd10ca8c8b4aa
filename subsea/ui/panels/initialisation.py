"""Initialisation (Tu §9.1): numbers of everything, and scenario files."""

import random
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from imgui_bundle import imgui
from msgspec.structs import replace

from subsea.base.errors import UserError
from subsea.base.toml_files import locate_errors
from subsea.scenario import storage
from subsea.scenario.checks import check_scenario
from subsea.scenario.load import scenario_names
from subsea.scenario.schema import (
    MAX_FISHES,
    MAX_LEAVES,
    MAX_SEAWEED,
    MAX_SEED,
    MAX_SOLIDS,
    Scenario,
)
from subsea.ui.gui import INK, wrapped_text
from subsea.ui.panels.fields import PanelContext, typed_whole
from subsea.world.inventory import KINDS, Counts, counts, with_counts
from subsea.world.to_scenario import to_scenario

MAX_PLANKTON = 100_000
NUMBER, SEED, NAME = 6.5, 9.0, 14.0  # widths of fields, in heights of letters


@dataclass
class InitialisationState:
    """The entered values, until the dive starts with them."""

    base: Scenario | None = None  # scenario of these numbers
    counts: Counts | None = None
    names: list[str] = field(default_factory=list)  # of scenarios
    to_open: str = ""  # the name or path to open
    title: str = ""  # the name or path to save as
    message: str = ""  # result of the last action

    def begin(self, scenario: Scenario, seed: int) -> Counts:
        """Start from the numbers of a scenario and the seed of its dive."""
        self.base, self.counts = scenario, counts(scenario)
        self.counts.seed, self.names = seed, scenario_names()
        return self.counts


def panel(context: PanelContext) -> None:
    """Numbers of everything, and the files of scenarios."""
    draft, dive = context.state(InitialisationState), context.dive
    numbers = draft.counts
    if numbers is None or draft.base is not dive.scenario:
        numbers = draft.begin(dive.scenario, dive.world.state.seed)
    imgui.text(dive.scenario.title)
    imgui.same_line()
    imgui.text_disabled(dive.source.name)
    if imgui.begin_table("numbers", 2):
        imgui.table_next_column()
        _fishes(numbers)
        imgui.table_next_column()
        _sea(numbers)
        imgui.end_table()
    if imgui.button("Restart"):
        context.later(partial(restart, context, numbers))
    imgui.same_line()
    if imgui.button("Revert"):
        draft.begin(dive.scenario, dive.world.state.seed)
    imgui.same_line()
    imgui.text(f"{sum(numbers.fishes.values())} fishes in all")
    imgui.separator()
    _files(context, draft)
    if draft.message:
        wrapped_text(draft.message, INK, 38.0)


def restart(context: PanelContext, numbers: Counts) -> bool:
    """Start the dive with these numbers; False, with a note, if that is not possible."""
    draft, dive = context.state(InitialisationState), context.dive
    scenario = with_counts(present(context), numbers)
    try:
        with locate_errors(scenario, "the numbers"):
            check_scenario(scenario)
    except UserError as fault:
        draft.message = str(fault)
        dive.note(draft.message)
        return False
    if not dive.open_world(scenario, dive.source):
        draft.message = "That dive cannot begin."
        return False
    draft.message = ""
    return True


def open_file(context: PanelContext, name: str) -> bool:
    """Start another scenario, by name or path; False, with a note, if not possible."""
    draft, dive = context.state(InitialisationState), context.dive
    try:
        scenario, path, _ = storage.opened(name)
    except UserError as fault:
        draft.message = str(fault)
        dive.note(draft.message)
        return False
    draft.message, known = "", storage.held(path)
    if not dive.open_world(scenario, path):
        return False
    dive.known = known
    return True


def save(context: PanelContext, name: str = "") -> Path | None:
    """Save the current scenario under a name, or in its file; returns the path if saved."""
    draft, dive = context.state(InitialisationState), context.dive
    try:
        path = storage.place_named(name.strip()) if name else storage.place_of(dive.source)
        storage.save(present(context), path, dive.source, dive.known)
    except UserError as fault:
        draft.message = str(fault)
        dive.note(draft.message)
        return None
    dive.source, dive.known = path, storage.held(path)
    draft.names, draft.message = scenario_names(), f"saved as {path}"
    dive.note(draft.message)
    return path


def present(context: PanelContext) -> Scenario:
    """The dive's scenario with the changes of panels."""
    world = context.dive.world
    return replace(to_scenario(world), seed=world.state.seed)


def _fishes(numbers: Counts) -> None:
    for species, number in numbers.fishes.items():
        numbers.fishes[species] = _number(species.replace("_", " "), number, MAX_FISHES)


def _sea(numbers: Counts) -> None:
    numbers.plankton = _number("plankton", numbers.plankton, MAX_PLANKTON, 100)
    for kind in KINDS:
        numbers.clusters[kind] = _number(f"##{kind}", numbers.clusters[kind], MAX_SEAWEED)
        imgui.same_line()
        numbers.leaves[kind] = _number(f"{kind} × leaves", numbers.leaves[kind], MAX_LEAVES, low=1)
        imgui.set_item_tooltip("clusters of seaweed, and the leaves of each")
    numbers.pillars = _number("pillars", numbers.pillars, MAX_SOLIDS)
    numbers.seed = _number("seed", numbers.seed, MAX_SEED, wide=SEED)
    imgui.same_line()
    if imgui.button("Dice"):
        numbers.seed = random.randrange(1_000_000)
    imgui.set_item_tooltip("another seed: other places, sizes and whims")


def _number(
    name: str, value: int, high: int, step: int = 1, low: int = 0, wide: float = NUMBER
) -> int:
    imgui.set_next_item_width(wide * imgui.get_font_size())
    return typed_whole(name, value, low, high, step)


def _files(context: PanelContext, draft: InitialisationState) -> None:
    line = imgui.get_font_size()
    imgui.set_next_item_width(NAME * line)
    chosen = imgui.begin_combo("##there", "scenarios", imgui.ComboFlags_.height_large.value)
    if chosen:
        for name in draft.names:
            if imgui.selectable(name, name == context.dive.source.stem)[0]:
                context.later(partial(open_file, context, name))
        imgui.end_combo()
    imgui.same_line()
    draft.to_open, entered = _line("##wanted", "or the path of a file", draft.to_open)
    imgui.same_line()
    if (imgui.button("Open") or entered) and draft.to_open.strip():
        context.later(partial(open_file, context, draft.to_open.strip()))
    if imgui.button("Save"):
        context.later(partial(save, context))
    imgui.set_item_tooltip(str(storage.place_of(context.dive.source)))
    imgui.same_line()
    draft.title, entered = _line("##title", "name or path", draft.title)
    imgui.same_line()
    if (imgui.button("Save as") or entered) and draft.title.strip():
        context.later(partial(save, context, draft.title))


def _line(name: str, hint: str, text: str) -> tuple[str, bool]:
    """A text field: its text, and whether Enter was pressed."""
    imgui.set_next_item_width(NAME * imgui.get_font_size())
    _, text = imgui.input_text_with_hint(name, hint, text)
    return text, imgui.is_item_deactivated() and imgui.is_key_pressed(imgui.Key.enter)
