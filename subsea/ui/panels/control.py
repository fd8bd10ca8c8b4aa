"""Control (Tu fig. 9.6): diagrams, pictures, the camera, timing, and the time of the world."""

import glfw
import numpy as np
from imgui_bundle import imgui

from subsea.dive.timeline import RATES
from subsea.frame.diagrams import DIAGRAMS
from subsea.ui.gui import CLAMP
from subsea.ui.panels.fields import PanelContext, radio_row
from subsea.view.camera import View
from subsea.world.world import TICK_S

ACROSS = 8.0  # of a column of diagrams, in heights of letters
AHEAD_CM = 200.0  # distance of the point that a waypoint looks at
CALM = 0.05  # weight of the newest time in the smoothed ones


class StageTimes:
    """Smoothed times of the stages of a tick."""

    def __init__(self) -> None:
        self.ms: dict[str, float] = {}

    def follow(self, stages_s: dict[str, float]) -> None:
        """Add the last tick's."""
        for name, seconds in stages_s.items():
            new = 1000.0 * seconds
            self.ms[name] = new + (1.0 - CALM) * (self.ms.get(name, new) - new)


def panel(context: PanelContext) -> None:
    """Draw the panel, and control the dive."""
    _diagrams(context)
    imgui.separator()
    _recording(context)
    imgui.separator()
    _camera(context)
    imgui.separator()
    _speed(context)


def _diagrams(context: PanelContext) -> None:
    dive, line = context.dive, imgui.get_font_size()
    for number, (name, meaning) in enumerate(DIAGRAMS.items()):
        if number % 3:
            imgui.same_line(1.0 + number % 3 * ACROSS * line)
        changed, shown = imgui.checkbox(name, name in dive.picture.diagrams)
        imgui.set_item_tooltip(meaning)
        if changed:
            (dive.picture.diagrams.add if shown else dive.picture.diagrams.discard)(name)
    _, dive.picture.wireframe = imgui.checkbox("wireframe", dive.picture.wireframe)
    imgui.same_line(1.0 + ACROSS * line)
    if imgui.checkbox("lights", bool(dive.world.state.submarine.lights[0]))[0]:
        dive.run_command("lights")


def _recording(context: PanelContext) -> None:
    if imgui.button("take a picture"):
        context.dive.run_command("picture")
    imgui.same_line()
    if imgui.button("film, or end the film"):
        context.dive.run_command("film")


def _camera(context: PanelContext) -> None:
    dive = context.dive
    front_view = dive.picture.front_view
    if front_view is None:
        imgui.text_disabled("All round, the camera looks everywhere.")
        return
    (x, y, z), (heading, pitch) = front_view.view.eye, angles_deg(front_view.view)
    imgui.text(f"camera {x:.0f}, {y:.0f}, {z:.0f} cm; heading {heading:.0f}°, pitch {pitch:+.0f}°")
    if imgui.button("copy it as a waypoint of a tour"):
        text = waypoint(front_view.view, dive.world.state.tick * TICK_S)
        glfw.set_clipboard_string(None, text)  # type: ignore[arg-type]  # any window is deprecated
        dive.overlay.note("the waypoint can be pasted into a scenario")


def _speed(context: PanelContext) -> None:
    """Times of a picture and of the stages of a tick, and counts."""
    times, line = context.state(StageTimes), imgui.get_font_size()
    times.follow(context.dive.world.stages_s)
    rate = max(imgui.get_io().framerate, 1e-3)
    imgui.text(f"{1000.0 / rate:.1f} ms a picture, {rate:.0f} pictures a second")
    for number, (name, ms) in enumerate(times.ms.items()):
        if number % 3:
            imgui.same_line(1.0 + number % 3 * ACROSS * line)
        imgui.text_disabled(f"{name} {ms:.2f} ms")
    counts = context.dive.picture.counts
    imgui.text(", ".join(f"{number:,} {name}" for name, number in counts.items()))


def angles_deg(view: View) -> tuple[float, float]:
    """Heading, left of the x axis, in [0, 360), and pitch, up, of a view."""
    ahead = -view.view[2, :3].astype(np.float64)
    heading = np.degrees(np.arctan2(ahead[1], ahead[0])) % 360.0
    return float(heading), float(np.degrees(np.arcsin(np.clip(ahead[2], -1.0, 1.0))))


def waypoint(view: View, time_s: float) -> str:
    """A waypoint for a scenario file, with the place and direction of a view."""
    eye = np.asarray(view.eye, np.float64)
    ahead = eye - AHEAD_CM * view.view[2, :3].astype(np.float64)
    position, target = (", ".join(f"{value:.1f}" for value in place) for place in (eye, ahead))
    return f"{{ time_s = {time_s:.1f}, position_cm = [{position}], look_at_cm = [{target}] }},\n"


BACK_WIDE = 24.0  # of the slider, in heights of letters
RATE_NAMES = {0.25: "×¼", 0.5: "×½"}


def time_panel(context: PanelContext) -> None:
    """Draw the panel of time: pause, single ticks, rates, and rewind over the last minute."""
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
    rates = ((RATE_NAMES.get(rate, f"×{rate:g}"), rate) for rate in RATES)
    if (rate := radio_row(rates, time.rate)) is not None:
        time.run_at(rate)
    imgui.set_next_item_width(BACK_WIDE * line)
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
