"""Habits (Tu fig. 9.5): sex, kind and likings, of one fish or all of its species."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from imgui_bundle import imgui

from subsea.behavior.mental_state import HABITS, apply_individual
from subsea.scenario.schema import IndividualTable
from subsea.state import KINDS
from subsea.ui.context import PanelContext
from subsea.ui.panels.fish_picker import choose_fish
from subsea.world.world import TICK_S

PAIRS = ((0, 1, "light"), (2, 3, "temperature"))  # pairs of columns of `minds.likes`
INDENT = 7.0  # of choices, in heights of letters


@dataclass
class HabitsScope:
    """True if habits are set for one fish or all of its species."""

    all_of_species: bool = False


def panel(context: PanelContext) -> None:
    """Draw the panel, and change the world."""
    fish = choose_fish(context)
    if fish is None:
        return
    world = context.dive.world
    minds, scope = world.state.minds, context.state(HabitsScope)
    name = world.species[world.state.fishes.species[fish]].name
    _row("of")
    for label, every in (("this fish alone", False), (f"all of {name}", True)):
        if imgui.radio_button(label, scope.all_of_species == every):
            scope.all_of_species = every
        imgui.same_line()
    imgui.new_line()
    imgui.separator()
    _row("sex")
    for label, male in (("female", False), ("male", True)):
        if imgui.radio_button(label, bool(minds.male[fish]) == male):
            _set(context, fish, male=male)
        imgui.same_line()
    imgui.new_line()
    _row("kind")
    for code, kind in enumerate(KINDS):
        if imgui.radio_button(kind, int(minds.kind[fish]) == code):
            _set(context, fish, kind=kind)
        imgui.same_line()
    imgui.new_line()
    _row("company")
    changed, schools = imgui.checkbox("likes schooling", bool(minds.schools[fish]))
    if changed:
        _set(context, fish, schooling=schools)
    for one, other, what in PAIRS:
        _row(what)
        for column in (one, other):
            changed, liked = imgui.checkbox(HABITS[column], bool(minds.likes[fish, column]))
            if changed:
                likes = minds.likes[fish].copy()
                likes[column] = liked
                names = [name for name, on in zip(HABITS, likes, strict=True) if on]
                _set(context, fish, likes=names)
            imgui.same_line()
        if minds.likes[fish, one] == minds.likes[fish, other]:
            imgui.text_disabled("doesn't care")
        else:
            imgui.new_line()


def _row(name: str) -> None:
    """Begin a row of choices with its name."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(name)
    imgui.same_line(INDENT * imgui.get_font_size())


def _set(context: PanelContext, fish: int, **habits: Any) -> None:
    """Set habits of a fish, or of all living fishes of its species."""
    world = context.dive.world
    fishes, minds = world.state.fishes, world.state.minds
    those = np.array([fish])
    if context.state(HabitsScope).all_of_species:
        those = np.flatnonzero((fishes.species == fishes.species[fish]) & fishes.alive)
    for one in those:
        apply_individual(
            fishes, minds, IndividualTable(fish=int(one), **habits), world.state.tick * TICK_S
        )
    context.changed()
