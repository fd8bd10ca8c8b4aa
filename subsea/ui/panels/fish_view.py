"""Fish view (Tu fig. 9.7): the point of view, and the eyes of a fish."""

from imgui_bundle import imgui

from subsea.dive.options import RETINA_COLOURS
from subsea.dive.ride import MOST_PAN_DEG, MOST_TILT_DEG
from subsea.ui.context import PanelContext
from subsea.ui.gui import CLAMP
from subsea.ui.panels.fish_picker import choose_fish
from subsea.view.retina import Gaze

WIDE = 16.0  # of a slider, in heights of letters
PLACES = (("the submarine", None), ("behind the fish", True), ("the fish's eyes", False))


def panel(context: PanelContext) -> None:
    """Draw the panel, and control the dive."""
    dive, fish = context.dive, choose_fish(context)
    ride = dive.picture.ride
    imgui.begin_disabled(fish is None)
    for name, behind in PLACES:
        now = (ride.behind if ride else None) == behind
        if imgui.radio_button(name, now) and not now:
            _see_from(context, fish, behind)
        imgui.same_line()
    imgui.new_line()
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
    for look in RETINA_COLOURS:
        if imgui.radio_button(look, dive.picture.colours == look):
            dive.picture.colours = look
        imgui.same_line()
    imgui.new_line()
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
