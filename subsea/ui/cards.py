"""Three cards for visitors: a fish's mind, what its eyes see, and changes of the sea.

They are docked at the sides of the screen, and move aside for the chosen fish.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from imgui_bundle import imgui
from msgspec.structs import replace

from subsea.base.errors import UserError
from subsea.base.language import marked, translated
from subsea.base.toml_files import locate_errors
from subsea.dive.options import RetinaColours
from subsea.dive.plain_words import sentence
from subsea.habitat.day import HOURS, hour_at
from subsea.rendering.gl.textures import ImageTexture
from subsea.scenario.checks import check_scenario
from subsea.scenario.schema import MAX_FISHES, Scenario
from subsea.state import FEAR, HUNGER, LIBIDO, NOBODY, SUBMARINE
from subsea.ui.gui import CLAMP, INK, LIT, MARK, QUIET, WARM, Rgb, colour, wrapped_text
from subsea.ui.panels.fields import Area, PanelContext
from subsea.ui.panels.initialisation import present
from subsea.world.inventory import counts, with_counts
from subsea.world.world import TICK_S, World

MIND, EYES, SEA = marked("Mind"), marked("Eyes"), marked("Change the sea")
WIDE = 19.0  # of the content of a card, in heights of letters
GAP = 0.6  # between cards, in heights of letters
CHOOSE = marked("Click a fish in the sea.")
BARS: tuple[tuple[int, str, Rgb], ...] = (
    (HUNGER, marked("hunger"), WARM),
    (LIBIDO, marked("love"), MARK),
    (FEAR, marked("fear"), INK),
)
LIKES, DISLIKES, NO_FRIENDS = (
    marked("Likes: {names}"), marked("Shuns: {names}"), marked("Likes nobody in particular yet."),
)  # fmt: skip
FEW = 3  # names of fishes that it likes
LOOKS: tuple[tuple[str, RetinaColours], ...] = (
    (marked("as it is"), "colours"), (marked("who is who"), "identity"),
    (marked("how far"), "range"),
)  # fmt: skip
AGAIN_S = 0.4  # between two pictures of a fish's eyes
EYE_PX = 192, 144
STRONGEST_CM_S = 60.0  # largest current of its slider
MORE_FISHES, LEAST_FISHES = 3, 30  # end of the slider, times their number; at least


def mind(context: PanelContext) -> None:
    """Show what the chosen fish feels and wants, in plain words."""
    world, fish, line = context.dive.world, context.chosen, imgui.get_font_size()
    if fish is None:
        _hint(CHOOSE)
        return
    name = translated(world.species[world.state.fishes.species[fish]].name)
    imgui.push_font(None, 1.2 * line)
    imgui.text_colored((*MARK, 1.0), name)
    imgui.pop_font()
    # Room for two lines, so that the card keeps its size.
    top = imgui.get_cursor_pos_y()
    wrapped_text(sentence(world, fish), INK, WIDE)
    imgui.set_cursor_pos_y(max(imgui.get_cursor_pos_y(), top + 2.4 * line))
    for row, words, rgb in BARS:
        _bar(translated(words), float(world.state.minds.mental[fish, row]), rgb)
    wrapped_text(companions(world, fish), QUIET, WIDE)


def _hint(words: str) -> None:
    imgui.dummy((WIDE * imgui.get_font_size(), 0.0))
    wrapped_text(translated(words), QUIET, WIDE)


def _bar(words: str, share: float, rgb: Rgb) -> None:
    """Draw a bar with its name at the left."""
    line, corner = imgui.get_font_size(), imgui.get_cursor_screen_pos()
    begin, end = corner.x + 0.4 * WIDE * line, corner.x + WIDE * line
    low, high = corner.y + 0.25 * line, corner.y + 0.95 * line
    canvas = imgui.get_window_draw_list()
    canvas.add_text((corner.x, corner.y), colour(INK), words)
    canvas.add_rect_filled((begin, low), (end, high), colour(LIT, 0.35), 0.3 * line)
    tip = begin + min(max(share, 0.0), 1.0) * (end - begin)
    if tip > begin + 1.0:
        canvas.add_rect_filled((begin, low), (tip, high), colour(rgb), 0.3 * line)
    imgui.dummy((WIDE * line, 1.25 * line))


def companions(world: World, fish: int) -> str:
    """Say whom a fish likes, else whom it shuns, in the language of visitors."""
    minds, species = world.state.minds, world.state.fishes.species
    names: dict[bool, list[str]] = {True: [], False: []}
    for k in np.argsort(-np.abs(minds.liking[fish]), kind="stable"):
        other, strength = int(minds.liked[fish, k]), float(minds.liking[fish, k])
        if other == NOBODY or strength == 0.0:
            continue
        name = marked("you") if other == SUBMARINE else world.species[species[other]].name
        if translated(name) not in names[strength > 0.0]:
            names[strength > 0.0].append(translated(name))
    for words, found in ((LIKES, names[True]), (DISLIKES, names[False])):
        if found:
            return translated(words).format(names=", ".join(found[:FEW]))
    return translated(NO_FRIENDS)


class EyePictures:
    """The picture of what both eyes of the chosen fish see, on the GPU."""

    def __init__(self) -> None:
        self.texture: ImageTexture | None = None
        self.fish = -1  # the fish whose eyes it shows
        self._due_s = 0.0

    def follow(self, context: PanelContext, fish: int) -> None:
        """Have the picture drawn again after this frame, now and then."""
        self._due_s -= imgui.get_io().delta_time
        if self._due_s <= 0.0 or fish != self.fish:
            self._due_s, self.fish = AGAIN_S, fish
            context.later(partial(self._draw, context, fish))

    def _draw(self, context: PanelContext, fish: int) -> None:
        picture = context.dive.picture
        if fish < len(context.dive.world.state.fishes.alive):  # else the world was replaced
            pixels = picture.through_eyes(fish, EYE_PX)
            self.release()
            self.texture = picture.upload(pixels)

    def release(self) -> None:
        """Free the texture."""
        if self.texture is not None:
            self.texture.release()
            self.texture = None


def eyes(context: PanelContext) -> None:
    """Show the pictures of both eyes of the chosen fish, and choose their colours."""
    picture, fish, line = context.dive.picture, context.chosen, imgui.get_font_size()
    seen = context.state(EyePictures)
    if fish is None:
        _hint(CHOOSE)
        return
    if not picture.insets:  # else a ride shows them in the corners
        seen.follow(context, fish)
        size = WIDE * line, WIDE * line * EYE_PX[1] / (2 * EYE_PX[0])
        if seen.texture is None:
            imgui.dummy(size)
        else:
            imgui.image(imgui.ImTextureRef(seen.texture.glo), size)
    for number, (words, look) in enumerate(LOOKS):
        if number:
            imgui.same_line()
        if imgui.radio_button(translated(words), picture.colours == look):
            picture.colours = look
            seen.fish = -1


@dataclass
class Moved:
    """Values of sliders that act when they are released."""

    hour: float | None = None
    fishes: int | None = None
    start: tuple[Scenario, tuple[float, float]] | None = None  # before the first change
    source: object = None  # file of the scenario of `start`


def sea(context: PanelContext) -> None:
    """Change the current, the hour and the number of fishes, and feed them."""
    dive, moved, line = context.dive, context.state(Moved), imgui.get_font_size()
    world, water = dive.world, dive.scenario.water
    if moved.start is None or moved.source != dive.source:
        moved.start, moved.source = (dive.scenario, world.current_cm_s), dive.source
    imgui.push_item_width(WIDE * line)
    _current(context)
    now = hour_at(water.hour, water.day_minutes, world.state.tick * TICK_S)
    shown = now if moved.hour is None else moved.hour
    _title(marked("Hour of the day"), f"{int(shown):02d}:{int(shown % 1.0 * 60.0):02d}")
    changed, hour = imgui.slider_float("##hour", shown, 0.0, HOURS - 0.1, "", CLAMP)
    if changed:
        moved.hour = round(hour, 1)
    if imgui.is_item_deactivated_after_edit() and moved.hour is not None:
        start = (moved.hour - now + water.hour) % HOURS
        context.later(partial(_rebuild, context, water_at(dive.scenario, start)))
        moved.hour = None
    _fishes(context, moved)
    imgui.pop_item_width()
    if imgui.button(translated("Feed"), (0.48 * WIDE * line, 0.0)):
        dive.run_command("feed")
    imgui.same_line(0.0, 0.04 * WIDE * line)
    if imgui.button(translated("As it was"), (0.48 * WIDE * line, 0.0)):
        scenario, current = moved.start
        world.current_cm_s = current
        context.changed()
        if scenario is not dive.scenario:
            context.later(partial(_rebuild, context, scenario))


def water_at(scenario: Scenario, hour: float) -> Scenario:
    """A scenario that begins at another hour of the day."""
    return replace(scenario, water=replace(scenario.water, hour=round(hour, 2)))


def _title(words: str, value: str) -> None:
    """Write what the next slider sets, and its value at the right, where no handle covers it."""
    imgui.text_colored((*QUIET, 1.0), translated(words))
    right = imgui.get_cursor_start_pos().x + WIDE * imgui.get_font_size()
    imgui.same_line(right - imgui.calc_text_size(value).x)
    imgui.text(value)


def _current(context: PanelContext) -> None:
    """Draw the slider of the current, which keeps its direction."""
    world = context.dive.world
    x, y = world.current_cm_s
    strength = math.hypot(x, y)
    _title(marked("Current"), f"{strength:.0f} cm/s")
    most = max(STRONGEST_CM_S, strength)
    moved, wanted = imgui.slider_float("##current", strength, 0.0, most, "", CLAMP)
    if moved:
        way = (x / strength, y / strength) if strength else (1.0, 0.0)
        world.current_cm_s = round(wanted * way[0], 2), round(wanted * way[1], 2)
        context.changed()


def _fishes(context: PanelContext, moved: Moved) -> None:
    """Draw the slider of the number of fishes of a species: that of the chosen fish, or the first.

    The fishes begin again with another number.
    """
    dive, world = context.dive, context.dive.world
    fishes = world.state.fishes
    if not world.species:
        return
    kind = 0 if context.chosen is None else int(fishes.species[context.chosen])
    if moved.start is None:
        return
    species, scenario = dive.scenario.species[kind], dive.scenario
    there = counts(scenario).fishes[species]
    first = counts(moved.start[0]).fishes.get(species, 0)
    most = min(max(MORE_FISHES * first, LEAST_FISHES), MAX_FISHES)
    shown = there if moved.fishes is None else moved.fishes
    _title(world.species[kind].name, str(shown))
    changed, number = imgui.slider_int("##fishes", shown, 0, max(most, there), "")
    if changed:
        moved.fishes = min(max(number, 0), max(most, there))
    if imgui.is_item_deactivated_after_edit() and moved.fishes is not None:
        wanted = counts(scenario)
        wanted.fishes[species], moved.fishes = moved.fishes, None
        context.later(partial(_rebuild, context, with_counts(present(context), wanted)))


def _rebuild(context: PanelContext, scenario: Scenario) -> None:
    """Go on in a changed scenario, with the same fish chosen."""
    dive, chosen = context.dive, context.chosen
    try:
        with locate_errors(scenario, translated("The sea")):
            check_scenario(scenario)
        changed = dive.change_world(scenario)
    except UserError as fault:
        dive.note(str(fault))
        return
    if changed:
        alive = dive.world.state.fishes.alive
        context.chosen = chosen if chosen is not None and chosen < len(alive) else None


CARDS: dict[str, Callable[[PanelContext], None]] = {MIND: mind, EYES: eyes, SEA: sea}
"""The cards by their names on the bar, in its order."""
SIDES = {MIND: 0, EYES: 1, SEA: 1}  # of the screen: left, right


def dock(
    sizes: Mapping[str, tuple[float, float]], before: Mapping[str, Area], room: Area,
    kept: Sequence[Area], gap: float,
) -> dict[str, Area]:  # fmt: skip
    """Place cards of some sizes at the sides of a room, off the `kept` areas and one another.

    A card stays where it was `before` as long as it covers nothing. Where there is not room for
    all, a card covers as little of the kept areas as it can.
    """
    there, placed = before, dict[str, Area]()
    for _ in range(2):  # again, as a card that moves may take the place of a later one
        placed = {}
        for name, (wide, high) in sizes.items():
            least: tuple[float, ...] = (math.inf,)
            others = [placed.get(other, there.get(other)) for other in sizes if other != name]
            taken = [area for area in others if area is not None]
            for area, far in _docks(
                name, (wide, high), there.get(name), room, (*kept, *taken), gap
            ):
                covered = sum(common(area, one) for one in kept)
                cost = round(covered), round(sum(common(area, one) for one in taken)), far
                if cost < least:
                    placed[name], least = area, cost
        there = placed
    return placed


def _docks(
    name: str, size: tuple[float, float], before: Area | None, room: Area, things: Sequence[Area],
    gap: float,
) -> list[tuple[Area, float]]:  # fmt: skip
    """All places at the sides for a card, each with how far it is from the preferred one."""
    (left, top, width, height), (wide, high) = room, size
    columns = [left, left + width - wide]
    last = max(top + height - high, top)
    rows = {top, last} | {y + down + gap for _, y, _, down in things}
    rows |= {y - gap - high for _, y, _, _ in things}
    found = []
    if before is not None:
        x = columns[before[0] + before[2] / 2 > left + width / 2]
        found.append(((x, min(max(before[1], top), last), wide, high), 0.0))
    for (side, x), y in itertools.product(enumerate(columns), rows):
        if top <= y <= last:
            home = SIDES.get(name, 1) == side
            found.append(((x, y, wide, high), 1.0 + (y - top) / height + 2.0 * (not home)))
    return found


def common(one: Area, other: Area) -> float:
    """The area that two panels share."""
    (x, y, width, height), (left, top, across, down) = one, other
    shared_x = min(x + width, left + across) - max(x, left)
    shared_y = min(y + height, top + down) - max(y, top)
    return max(shared_x, 0.0) * max(shared_y, 0.0)
