"""Choose a fish, the head of all panels about one fish; fish view (Tu fig. 9.7)."""

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from subsea.dive.options import RETINA_COLOURS
from subsea.dive.ride import MOST_PAN_DEG, MOST_TILT_DEG
from subsea.ui.gui import CLAMP
from subsea.ui.panels.fields import PanelContext, radio_row
from subsea.view.retina import Gaze
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


WIDE = 16.0  # of a slider, in heights of letters
PLACES = (("the submarine", None), ("behind the fish", True), ("the fish's eyes", False))


def panel(context: PanelContext) -> None:
    """Draw the panel, and control the dive."""
    dive, fish = context.dive, choose_fish(context)
    ride = dive.picture.ride
    imgui.begin_disabled(fish is None)
    for number, (name, behind) in enumerate(PLACES):
        now = (ride.behind if ride else None) == behind
        if number:
            imgui.same_line()
        if imgui.radio_button(name, now) and not now:
            _see_from(context, fish, behind)
    imgui.end_disabled()
    if ride is not None and fish is not None and ride.by.fish != fish:
        _see_from(context, fish, ride.behind)  # another one was chosen
    imgui.begin_disabled(ride is None)
    _eyes(context)
    imgui.end_disabled()


def _see_from(context: PanelContext, fish: int | None, behind: bool | None) -> None:
    """Look from behind a fish, through its eyes, or (None) from the submarine."""
    chosen = None if behind is None else fish
    context.later(lambda: context.dive.ride_fish(chosen, behind))


def _eyes(context: PanelContext) -> None:
    """Draw gaze, retina pictures and teleoperation of the ridden fish."""
    dive, ride = context.dive, context.dive.picture.ride
    gaze = ride.gaze if ride else Gaze()
    imgui.separator()
    imgui.push_item_width(WIDE * imgui.get_font_size())
    turned, pan = imgui.slider_float(
        "pan", gaze.pan_deg, -MOST_PAN_DEG, MOST_PAN_DEG, "%.0f°", CLAMP
    )
    raised, tilt = imgui.slider_float(
        "tilt", gaze.tilt_deg, -MOST_TILT_DEG, MOST_TILT_DEG, "%.0f°", CLAMP
    )
    imgui.pop_item_width()
    if ride and (turned or raised):
        ride.gaze = Gaze(pan, tilt)
    if imgui.button("look ahead") and ride:
        ride.gaze = Gaze()
    imgui.separator()
    _, dive.picture.eyes_shown = imgui.checkbox("pictures of both eyes", dive.picture.eyes_shown)
    looks = zip(RETINA_COLOURS, RETINA_COLOURS, strict=True)
    if (look := radio_row(looks, dive.picture.colours)) is not None:
        dive.picture.colours = look
    imgui.separator()
    changed, dive.see_brightness = imgui.checkbox(
        "goes by the light in its eyes", dive.see_brightness
    )
    if changed and not dive.see_brightness:
        dive.world.seen_light.clear()
    if ride:
        light = dive.world.state.minds.light[ride.by.fish]
        imgui.same_line()
        imgui.text_disabled(f"brightness {light:.0%}")
    changed, _ = imgui.checkbox("steer this fish", dive.steers_fish)
    if changed:
        dive.run_command("reins")
