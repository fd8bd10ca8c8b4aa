"""Behavior (Tu fig. 9.4) and habits: mental state, temper, character and likings of a fish."""

from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from subsea.behavior.mental_state import HABITS, apply_individual
from subsea.behavior.table import INTENTIONS
from subsea.dive.minds_text import SPAN, Chart, feelings, focus
from subsea.fish.character import TRAIT_RANGE
from subsea.scenario.schema import IndividualTable
from subsea.state import COURTSHIP, HUNGER, HUNT, KINDS, LIBIDO, MENTAL_STATES, Nature
from subsea.ui.gui import CLAMP, GLASS, INK, LIT, MARK, QUIET, WARM, button, colour
from subsea.ui.panels.fields import PanelContext, Slider, radio_row
from subsea.ui.panels.fish_picker import choose_fish
from subsea.world.world import TICK_S, World

WIDE, HIGH = 24.0, 3.0  # of a chart, in heights of letters
DIRECTIONS = ("left", "right", "ahead", "back", "up", "down")  # columns of `minds.preference`
LOGARITHMIC = imgui.SliderFlags_.logarithmic.value | CLAMP


TEMPER = (
    Slider("appetite", "meals that fill it", 1.0, 60.0, "%.0f"),
    Slider("digestion", "digestion, 1/s", 0.0005, 0.2, "%.4f", LOGARITHMIC),
    Slider("libido_rate", "libido grows, 1/s", 0.0005, 0.2, "%.4f", LOGARITHMIC),
    Slider("dread_cm", "dreads from, cm", 0.0, 1000.0, "%.0f"),
)
"""Parameters of the mental state of one fish: keys of `Individual` (Tu §7.4)."""
COLUMNS = {"dread_cm": "dread"}  # names in `state.Minds`, where they differ

NATURE = (
    Slider("vision_cm", "sees as far as, cm", 20.0, 2000.0, "%.0f"),
    Slider("smell_cm", "smells as far as, cm", 20.0, 2000.0, "%.0f"),
    Slider("standard_cm", "size of what it sees so far, cm", 2.0, 100.0, "%.0f"),
    Slider("hunger_stimulus", "food in sight makes hungry by", 0.0, 1.0, "%.2f"),
    Slider("libido_stimulus", "a mate in sight tempts by", 0.0, 1.0, "%.2f"),
    Slider("alarmed", "is alarmed by fear of", 0.0, 0.99, "%.2f"),
    Slider("panicked", "flees from fear of", 0.01, 1.0, "%.2f"),
    Slider("keen", "eats and mates for", 0.0, 1.0, "%.2f"),
    Slider("devotion_cm", "leaves a target for a nearer one, cm", 0.0, 500.0, "%.0f"),
    Slider("fatigue_s", "is tired of it after, s", 1.0, 600.0, "%.0f", LOGARITHMIC),
    Slider("fear_s", "loses most of its fear within, s", 1.0, 120.0, "%.0f", LOGARITHMIC),
    Slider("habituation_s", "half used to the submarine after, s", 5.0, 600.0, "%.0f", LOGARITHMIC),
    Slider("timidity", "keeps clear by, times the usual", 0.1, 5.0, "%.2f"),
    Slider("submarine_cm", "dreads the submarine from, cm", 0.0, 1000.0, "%.0f"),
    Slider("curiosity_cm", "is curious from, cm", 0.0, 2000.0, "%.0f"),
    Slider("dusk", "dark is below, share of the light", 0.0, 1.0, "%.2f"),
    Slider("mild", "cold is below, share of the warmth", 0.0, 1.0, "%.2f"),
    Slider("day_libido", "share of libido outside dusk", 0.0, 1.0, "%.2f"),
    Slider("calm_dread", "dread of a predator that cruises, times", 0.0, 1.0, "%.2f"),
)
"""Constants of all fishes: members of `state.Nature`."""


class ChartState:
    """The chart of the chosen fish."""

    def __init__(self) -> None:
        self.world: World | None = None
        self.chart = Chart(-1)

    def of(self, world: World, fish: int) -> Chart:
        """The chart of a fish up to now; new for another fish."""
        if self.world is not world or self.chart.fish != fish:
            self.world, self.chart = world, Chart(fish)
        self.chart.follow(world)
        return self.chart


def panel(context: PanelContext) -> None:
    """Draw the panel, and change the world."""
    world = context.dive.world
    fish = choose_fish(context)
    if fish is not None:
        _charts(context.state(ChartState).of(world, fish).values, world.nature)
        _intentions(world, fish)
        _preferences(world.state.minds.preference[fish])
        _temper(context, fish)
    if imgui.collapsing_header("Constants of all fishes"):
        _nature(context)


def _charts(values: NDArray[np.floating], nature: Nature) -> None:
    """Draw a chart of each mental state over the last minute, with its thresholds."""
    line = imgui.get_font_size()
    canvas, size = imgui.get_window_draw_list(), (WIDE * line, HIGH * line)
    marks = ((nature.keen,), (nature.keen,), (nature.alarmed, nature.panicked))
    imgui.push_style_color(imgui.Col_.frame_bg.value, (0.0, 0.0, 0.0, 0.0))
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (0.0, 0.0))
    imgui.push_style_var(imgui.StyleVar_.disabled_alpha.value, 1.0)
    imgui.begin_disabled()  # without tooltips
    for name, row, thresholds in zip(MENTAL_STATES, values, marks, strict=True):
        corner = imgui.get_cursor_screen_pos()
        end = corner.x + size[0], corner.y + size[1]
        canvas.add_rect_filled(corner, end, colour((0.13, 0.27, 0.34), 0.4), 4.0)
        for level in thresholds:
            y = end[1] - level * size[1]
            canvas.add_line((corner.x, y), (end[0], y), colour(WARM, 0.55), 1.0)
        share = len(row) / SPAN
        imgui.set_cursor_screen_pos((end[0] - share * size[0], corner.y))
        imgui.plot_lines(f"##{name}", row, 0, None, 0.0, 1.0, (max(share * size[0], 1.0), size[1]))
        imgui.set_cursor_screen_pos(corner)
        imgui.dummy(size)
        canvas.add_text(
            (corner.x + 0.4 * line, corner.y + 0.2 * line), colour(INK), f"{name} {row[-1]:.0%}"
        )
    imgui.end_disabled()
    imgui.pop_style_var(2)
    imgui.pop_style_color()


def _intentions(world: World, fish: int) -> None:
    """List all intentions, highlight the current one, and show its target."""
    minds, line = world.state.minds, imgui.get_font_size()
    names = imgui.Col_
    imgui.push_style_var(imgui.StyleVar_.disabled_alpha.value, 1.0)
    imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (0.25 * line, 0.25 * line))
    imgui.begin_disabled()  # not buttons
    for code, name in enumerate(INTENTIONS):
        lit = code == minds.intention[fish]
        imgui.push_style_color(names.button.value, (*LIT, 1.0) if lit else (*GLASS, 0.5))
        imgui.push_style_color(names.text.value, (*(INK if lit else QUIET), 1.0))
        imgui.button(name, (WIDE * line / 5.0 - 0.2 * line, 0.0))
        imgui.pop_style_color(2)
        if code % 5 < 4 and code < len(INTENTIONS) - 1:
            imgui.same_line()
    imgui.end_disabled()
    imgui.pop_style_var(2)
    what, far = focus(world, fish)
    about = f"about {what}" if far is None else f"about {what}, {far / 100.0:.2f} m away"
    if minds.courtship[fish]:
        about += f"; {COURTSHIP[minds.courtship[fish]]}"
    if minds.hunt[fish]:
        about += f"; {HUNT[minds.hunt[fish]]}"
    if minds.memory[fish] >= 0:
        about += f"; then {INTENTIONS[minds.memory[fish]]} again"
    imgui.text(about)


def _preferences(preference: NDArray[np.floating]) -> None:
    """Bars of motor preferences (Tu §6.5.2): recommendations right, warnings left."""
    line = imgui.get_font_size()
    canvas, corner = imgui.get_window_draw_list(), imgui.get_cursor_screen_pos()
    across, down, text = WIDE * line / 3.0, 1.25 * line, 3.0 * line
    half = (across - text - 0.6 * line) / 2.0
    for k, (name, share) in enumerate(zip(DIRECTIONS, preference, strict=True)):
        x, y = corner.x + k // 2 * across, corner.y + k % 2 * down
        canvas.add_text((x, y), colour(QUIET), name)
        middle = x + text + half
        canvas.add_rect_filled(
            (middle - half, y + 0.25 * line), (middle + half, y + 0.95 * line),
            colour((0.13, 0.27, 0.34), 0.4), 2.0,
        )  # fmt: skip
        tip = middle + half * float(np.clip(share, -1.0, 1.0))
        canvas.add_rect_filled(
            (min(middle, tip), y + 0.25 * line), (max(middle, tip), y + 0.95 * line),
            colour(MARK if share > 0.0 else WARM), 2.0,
        )  # fmt: skip
        canvas.add_line((middle, y + 0.15 * line), (middle, y + 1.05 * line), colour(QUIET, 0.6))
    imgui.dummy((WIDE * line, 2.0 * down))


def _temper(context: PanelContext, fish: int) -> None:
    """Sliders for hunger, libido and their parameters."""
    world = context.dive.world
    minds = world.state.minds
    imgui.push_item_width(0.5 * WIDE * imgui.get_font_size())
    set_to: dict[str, float] = {}
    for row in (HUNGER, LIBIDO):
        name = MENTAL_STATES[row]
        level = float(minds.mental[fish, row])
        moved, level = imgui.slider_float(name, level, 0.0, 1.0, "%.2f", CLAMP)
        if moved:
            set_to[name] = minds.mental[fish, row] = level  # shown until the fish updates it
    for slider in TEMPER:
        values = getattr(minds, COLUMNS.get(slider.name, slider.name))
        if (value := slider.draw(float(values[fish]))) is not None:
            set_to[slider.name] = value
    if set_to:
        individual = msgspec.structs.replace(IndividualTable(fish=fish), **set_to)
        apply_individual(world.state.fishes, minds, individual, world.state.tick * TICK_S)
        context.changed()
    imgui.pop_item_width()


def _nature(context: PanelContext) -> None:
    """A reset to the scenario's constants of all fishes, and their sliders."""
    world = context.dive.world
    before = Nature(**msgspec.structs.asdict(world.scenario.nature))
    if button("As in the scenario", world.nature != before):  # first, as the list is long
        world.nature = before
        context.changed()
    imgui.push_item_width(0.4 * WIDE * imgui.get_font_size())
    for slider in NATURE:
        if (value := slider.draw(getattr(world.nature, slider.name))) is not None:
            world.nature = ordered(world.nature, slider.name, value)
            context.changed()
    imgui.pop_item_width()


def ordered(nature: Nature, name: str, value: float) -> Nature:
    """Set one constant, and adapt those that must stay above or below it."""
    nature = nature._replace(**{name: value})
    if name == "vision_cm":
        return nature._replace(smell_cm=max(nature.smell_cm, value))
    if name == "smell_cm":
        return nature._replace(vision_cm=min(nature.vision_cm, value))
    if name == "alarmed":
        return nature._replace(panicked=max(nature.panicked, round(value + 0.01, 2)))
    if name == "panicked":
        return nature._replace(alarmed=min(nature.alarmed, round(value - 0.01, 2)))
    return nature


CHARACTER = (
    Slider("timidity", "timidity", *TRAIT_RANGE, "%.2f", LOGARITHMIC,
           "keeps farther from collisions, predators and the submarine"),
    Slider("activity", "activity", *TRAIT_RANGE, "%.2f", LOGARITHMIC,
           "swims faster and pauses less"),
    Slider("sociability", "sociability", *TRAIT_RANGE, "%.2f", LOGARITHMIC,
           "keeps nearer to its companions"),
    Slider("devotion", "devotion", *TRAIT_RANGE, "%.2f", LOGARITHMIC,
           "keeps its target, though another is nearer"),
    Slider("appetite", "appetite, meals", 1.0, 60.0, "%.1f", CLAMP, "eats more before it is full"),
)  # fmt: skip
"""Traits of one fish: keys of `Individual`; 1 is the usual fish."""

PAIRS = ((0, 1, "light"), (2, 3, "temperature"))  # pairs of columns of `minds.likes`
INDENT = 7.0  # of choices, in heights of letters


@dataclass
class HabitsScope:
    """True if habits are set for one fish or all of its species."""

    all_of_species: bool = False


def habits_panel(context: PanelContext) -> None:
    """Draw the panel of habits (Tu fig. 9.5): sex, kind, likings and character of a fish.

    Settings may be for all of its species. Its feelings for others are listed.
    """
    fish = choose_fish(context)
    if fish is None:
        return
    world = context.dive.world
    minds, scope = world.state.minds, context.state(HabitsScope)
    name = world.species[world.state.fishes.species[fish]].name
    _row("of")
    extents = ("this fish alone", False), (f"all of {name}", True)
    if (every := radio_row(extents, scope.all_of_species)) is not None:
        scope.all_of_species = every
    imgui.separator()
    _row("sex")
    sexes = ("female", False), ("male", True)
    if (male := radio_row(sexes, bool(minds.male[fish]))) is not None:
        _set_habits(context, fish, male=male)
    _row("kind")
    if (kind := radio_row(zip(KINDS, KINDS, strict=True), KINDS[minds.kind[fish]])) is not None:
        _set_habits(context, fish, kind=kind)
    _row("company")
    changed, schools = imgui.checkbox("likes schooling", bool(minds.schools[fish]))
    if changed:
        _set_habits(context, fish, schooling=schools)
    for first, second, what in PAIRS:
        _row(what)
        for column in (first, second):
            changed, liked = imgui.checkbox(HABITS[column], bool(minds.likes[fish, column]))
            if changed:
                likes = minds.likes[fish].copy()
                likes[column] = liked
                names = [name for name, on in zip(HABITS, likes, strict=True) if on]
                _set_habits(context, fish, likes=names)
            imgui.same_line()
        if minds.likes[fish, first] == minds.likes[fish, second]:
            imgui.text_disabled("doesn't care")
        else:
            imgui.new_line()
    imgui.separator()
    imgui.push_item_width(0.5 * WIDE * imgui.get_font_size())
    for slider in CHARACTER:
        if (value := slider.draw(float(getattr(minds, slider.name)[fish]))) is not None:
            _set_habits(context, fish, **{slider.name: value})
    imgui.pop_item_width()
    imgui.separator()
    for k, line in enumerate(feelings(world, fish) or ["none"]):
        _row("" if k else "feelings")
        imgui.text_disabled(line)


def _row(name: str) -> None:
    """Begin a row of choices with its name."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(name)
    imgui.same_line(INDENT * imgui.get_font_size())


def _set_habits(context: PanelContext, fish: int, **habits: Any) -> None:
    """Set habits of a fish, or of all living fishes of its species."""
    world = context.dive.world
    fishes, minds = world.state.fishes, world.state.minds
    chosen = np.array([fish])
    if context.state(HabitsScope).all_of_species:
        chosen = np.flatnonzero((fishes.species == fishes.species[fish]) & fishes.alive)
    for number in chosen.tolist():
        table = IndividualTable(fish=number, **habits)
        apply_individual(fishes, minds, table, world.state.tick * TICK_S)
    context.changed()
