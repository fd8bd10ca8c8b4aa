"""Physics (Tu fig. 9.3): bodies and water of simulated fishes, and currents."""

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from imgui_bundle import imgui
from msgspec.structs import replace

from subsea.base.errors import UserError
from subsea.scenario.schema import MAX_SIMULATED
from subsea.state import Physics
from subsea.ui.gui import CLAMP, MARK, QUIET, button, colour
from subsea.ui.panels.fields import PanelContext, Slider
from subsea.ui.panels.fish_picker import choose_fish

WIDE, DIAL = 13.0, 5.0  # of a slider and across the dial, in heights of letters
STRONGEST_CM_S = 60.0  # largest value here
SOME_CM_S = 6.0  # default of a current that is switched on
LOG = imgui.SliderFlags_.logarithmic.value | CLAMP


FACTORS = tuple(
    Slider(name, name.replace("_", " "), low, high, "%.3g", LOG, meaning)
    for name, low, high, meaning in (
        ("unit_mass", 0.1, 10.0, "factor on the mass of every node"),
        ("viscosity", 0.01, 100.0, "factor on the viscosity of every spring"),
        ("stiffness", 0.01, 100.0, "factor on the spring constants"),
        ("water_viscosity", 0.01, 100.0, "factor on what the water does"),
        ("time_step", 0.05, 50.0, "factor on the solver's 5.5 ms"),
    )
)
"""Sliders for the factors of `state.Physics`."""


@dataclass
class SavedCurrent:
    """The current that was switched off."""

    current_cm_s: tuple[float, float] = (SOME_CM_S, 0.0)


def panel(context: PanelContext) -> None:
    """Draw the panel, and change the world."""
    _simulated(context)
    imgui.separator()
    _factors(context)
    imgui.separator()
    _current(context)


def _simulated(context: PanelContext) -> None:
    dive = context.dive
    world, line = dive.world, imgui.get_font_size()
    live = np.flatnonzero(world.state.fishes.live)
    imgui.align_text_to_frame_padding()
    imgui.text(f"{len(live)} of {len(world.state.fishes.alive)} fishes are simulated; at most")
    imgui.same_line()
    imgui.set_next_item_width(5.5 * line)
    _, most = imgui.input_int("##most", len(world.state.live.fish))
    if imgui.is_item_deactivated_after_edit():
        context.later(partial(simulate, context, min(max(most, 0), MAX_SIMULATED)))
    imgui.text_disabled("Physics acts on these: those nearest to the submarine.")
    fish = choose_fish(context)
    if fish is None:
        return
    if not world.dynamics.muscular[world.state.fishes.species[fish]]:
        imgui.text_disabled("Its species has no muscles: it is played back.")
        return
    changed, first = imgui.checkbox("simulate it before all others", world.physics.fish == fish)
    imgui.same_line()
    imgui.text_disabled("it is simulated" if fish in live else "it is played back")
    if changed:
        world.physics = world.physics._replace(fish=fish if first else -1)
        context.changed()
        if first and not len(world.state.live.fish):
            context.later(partial(simulate, context, 1))


def simulate(context: PanelContext, most: int) -> bool:
    """Set the largest number of simulated fishes; False if not possible."""
    dive = context.dive
    if most == len(dive.world.state.live.fish):
        return True
    scenario, chosen = replace(dive.scenario, simulated=most), context.chosen
    try:
        entered = dive.change_world(scenario)
    except UserError as fault:
        dive.note_fault(str(fault))
        return False
    context.chosen = chosen if entered else context.chosen
    return entered


def _factors(context: PanelContext) -> None:
    world, line = context.dive.world, imgui.get_font_size()
    before = physics = world.physics
    for slider in FACTORS:
        imgui.set_next_item_width(WIDE * line)
        if (value := slider.draw(getattr(physics, slider.name))) is not None:
            factor: dict[str, Any] = {slider.name: value}
            physics = physics._replace(**factor)
    imgui.set_next_item_width(WIDE * line)
    moved, number = imgui.slider_int("iterations", physics.iterations, 1, 60)
    imgui.set_item_tooltip("steps of the solver in a tick; of 6 a fish lives as fast as others")
    if moved:
        physics = physics._replace(iterations=min(max(number, 1), 60))
    moved, on = imgui.checkbox("hydrodynamics", physics.hydrodynamics)
    imgui.set_item_tooltip("without it the tail beats, and the fish does not go")
    if moved:
        physics = physics._replace(hydrodynamics=on)
    imgui.same_line()
    defaults = Physics(fish=physics.fish)
    if button("Defaults", physics != defaults):
        physics = defaults
    if physics != before:
        world.physics = physics
        context.changed()
    burst = sorted(fish for fish, under in world.reported_bursts if under == world.physics)
    if burst:
        numbers = ", ".join(map(str, burst[:8])) + (" …" if len(burst) > 8 else "")
        imgui.text_disabled(
            f"exploded like that: {'fish' if len(burst) == 1 else 'fishes'} {numbers}"
        )


def _current(context: PanelContext) -> None:
    world, still, line = context.dive.world, context.state(SavedCurrent), imgui.get_font_size()
    x, y = world.current_cm_s
    on = bool(x or y)
    if on:
        still.current_cm_s = x, y
    x, y = still.current_cm_s
    strength, angle = math.hypot(x, y), math.atan2(y, x)
    before = on, strength, angle
    angle = _dial(angle, strength if on else 0.0, float(world.state.submarine.angles[0]))
    imgui.same_line()
    imgui.begin_group()
    _, on = imgui.checkbox("current", on)
    imgui.set_next_item_width(0.7 * WIDE * line)
    moved, wanted = imgui.slider_float(
        "strength", strength, 0.0, max(STRONGEST_CM_S, strength), "%.1f cm/s", CLAMP
    )
    strength = max(float(f"{wanted:.3g}"), 0.1) if moved else strength
    imgui.text_disabled(f"toward {round(-math.degrees(angle)) % 360:03d}° by the compass")
    imgui.end_group()
    if (on, strength, angle) != before:
        still.current_cm_s = (
            float(f"{strength * math.cos(angle):.4g}"), float(f"{strength * math.sin(angle):.4g}"),
        )  # fmt: skip
        world.current_cm_s = still.current_cm_s if on else (0.0, 0.0)
        context.changed()


def _dial(angle: float, strength: float, heading: float) -> float:
    """The sea from above, x to the right: an arrow that the pointer turns, and the submarine."""
    line = imgui.get_font_size()
    corner, size = imgui.get_cursor_screen_pos(), DIAL * line
    imgui.invisible_button("dial", (size, size))
    imgui.set_item_tooltip("where the current flows, from above; the mark is your heading")
    middle, radius = (corner.x + size / 2, corner.y + size / 2), 0.46 * size
    pointer = imgui.get_io().mouse_pos
    if imgui.is_item_active():
        away = pointer.x - middle[0], middle[1] - pointer.y
        if math.hypot(*away) > 0.1 * size:
            angle = math.radians(round(math.degrees(math.atan2(away[1], away[0]))))
    canvas = imgui.get_window_draw_list()
    canvas.add_circle_filled(middle, radius, colour((0.13, 0.27, 0.34), 0.55))
    canvas.add_circle(middle, radius, colour(QUIET, 0.6))

    def at(turn: float, share: float) -> tuple[float, float]:
        return (
            middle[0] + share * radius * math.cos(turn),
            middle[1] - share * radius * math.sin(turn),
        )

    canvas.add_triangle_filled(
        at(heading, 1.0), at(heading + 0.16, 0.78), at(heading - 0.16, 0.78), colour(QUIET, 0.8)
    )
    ink = colour(MARK, 0.95 if strength else 0.3)
    far = 0.35 + 0.4 * min(strength / STRONGEST_CM_S, 1.0) ** 0.5
    canvas.add_line(at(angle + math.pi, far), at(angle, far), ink, 0.14 * line)
    canvas.add_triangle_filled(
        at(angle, far + 0.22), at(angle + 0.35, far - 0.05), at(angle - 0.35, far - 0.05), ink
    )
    return angle
