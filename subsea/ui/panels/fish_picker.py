"""Choose a fish: the head of all panels about one fish."""

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from subsea.ui.context import PanelContext
from subsea.world.world import World

NUMBER = imgui.InputTextFlags_.enter_returns_true.value | imgui.InputTextFlags_.chars_decimal.value


def choose_fish(context: PanelContext) -> int | None:
    """Draw fields to choose a fish; returns the chosen one or None."""
    fishes, fish = context.dive.world.state.fishes, context.chosen
    line = imgui.get_font_size()
    for name, way, step in (("previous", imgui.Dir.left, -1), ("next", imgui.Dir.right, 1)):
        if imgui.arrow_button(name, way):
            context.chosen = next_fish(fish, step, fishes.alive)
        imgui.set_item_tooltip(f"the {name} fish")
        imgui.same_line()
    imgui.set_next_item_width(4.5 * line)
    entered, text = imgui.input_text_with_hint(
        "fish", "none", "" if fish is None else str(fish), NUMBER
    )
    if entered and text.isdecimal() and (number := int(text)) < len(fishes.alive):
        context.chosen = number if fishes.alive[number] else fish
    elif entered and not text:
        context.chosen = None
    if context.chosen is None:
        imgui.text_disabled("None is chosen: click one in the sea.")
        return None
    imgui.same_line(0.0, line)
    imgui.text(describe_fish(context.dive.world, context.chosen))
    return context.chosen


def describe_fish(world: World, fish: int) -> str:
    """A fish's species, length and sex, as a text."""
    fishes, minds = world.state.fishes, world.state.minds
    name = world.species[fishes.species[fish]].name
    sex = "male" if minds.male[fish] else "female"
    return f"{name}, {fishes.length[fish]:.1f} cm, {sex}"


def next_fish(fish: int | None, step: int, alive: NDArray[np.bool_]) -> int | None:
    """The next living fish, `step` 1 up or -1 down, cyclically; None if there is none."""
    living = np.flatnonzero(alive)
    if not len(living):
        return None
    if fish is None:
        return int(living[0 if step > 0 else -1])
    at = np.searchsorted(living, fish, side="right" if step > 0 else "left")
    return int(living[(at if step > 0 else at - 1) % len(living)])
