"""Time: pause, single ticks, rates, and rewind over the last minute."""

from imgui_bundle import imgui

from subsea.dive.timeline import RATES
from subsea.ui.context import PanelContext
from subsea.ui.gui import CLAMP
from subsea.world.world import TICK_S

WIDE = 24.0  # of the slider, in heights of letters
NAMES = {0.25: "×¼", 0.5: "×½"}


def panel(context: PanelContext) -> None:
    """Draw the panel, and control time."""
    time, line = context.dive.timeline, imgui.get_font_size()
    if time is None:
        imgui.text_disabled("Another computer makes the time of this dive.")
        return
    if imgui.button("go on" if time.paused else "pause", (5.0 * line, 0.0)):
        time.pause()
    imgui.same_line()
    if imgui.button("one tick"):
        time.single()
    imgui.same_line(0.0, 1.5 * line)
    for rate in RATES:
        if imgui.radio_button(NAMES.get(rate, f"×{rate:g}"), time.rate == rate):
            time.run_at(rate)
        imgui.same_line()
    imgui.new_line()
    imgui.set_next_item_width(WIDE * line)
    back = (time.tick - time.latest) * TICK_S
    reach = (time.earliest - time.latest) * TICK_S
    moved, back = imgui.slider_float("##back", back, min(reach, -TICK_S), 0.0, "%.1f s", CLAMP)
    if moved:
        time.stand_at(time.latest + round(back / TICK_S))
    imgui.text(f"tick {time.tick}, {minutes(time.tick)}")
    imgui.same_line()
    imgui.text_disabled(f"of {minutes(time.latest)}; back to {minutes(time.earliest)}")


def minutes(tick: int) -> str:
    """The time of a tick, in minutes and seconds."""
    seconds = tick * TICK_S
    return f"{int(seconds // 60)}:{seconds % 60:04.1f}"
