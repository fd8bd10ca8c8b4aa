"""The help: a mouse with the functions of its parts, and all keys in groups, as bound.

A new visitor sees three lines of it in the upper left corner, which leave the sea free.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

from imgui_bundle import imgui

from subsea.base.language import marked, translated
from subsea.dive.settings import Bindings, ControlName, key_words
from subsea.ui.gui import (
    GLASS,
    INK,
    LIT,
    MARK,
    QUIET,
    colour,
    draw_backing,
    draw_shadowed_text,
    ground,
    stroke,
)

MOUSE_WIDE, MOUSE_HIGH = 15.5, 15.0  # of the mouse and its labels, in heights of letters
COLUMNS = 4  # of keys at most
ROW, GAP = 1.38, 0.5  # height of a line, and between two groups
CAP = 1.15  # height of a key
MARGIN = 0.8  # around all columns
BRIEF_ROW, BRIEF_GAP = 1.5, 1.2  # of the three lines: height, and space between two parts
ARROWS = {"Left": (-1.0, 0.0), "Right": (1.0, 0.0), "Up": (0.0, -1.0), "Down": (0.0, 1.0)}

# Labels beside the mouse.
BESIDE_MOUSE: dict[ControlName, str] = {
    "ahead": marked("ahead"), "astern": marked("back"), "full stop": marked("stop"),
    "left": marked("left"), "right": marked("right"), "up": marked("nose up"),
    "down": marked("nose down"), "rise": marked("rise"), "dive": marked("dive"),
}  # fmt: skip
Pair = tuple[tuple[ControlName, ...], str]
GROUPS: tuple[tuple[str, tuple[Pair, ...]], ...] = (
    (marked("The helm"), (
        (("ahead", "astern"), marked("hold: ahead, back")),
        (("left", "right"), marked("hold: turn")),
        (("up", "down"), marked("hold: nose up, down")),
        (("rise", "dive"), marked("hold: rise, dive")),
        (("full stop",), marked("stop")),
        (("lights",), marked("lights")),
        (("recentre",), marked("look straight ahead")),
    )),
    (marked("Fishes"), (
        (("ride",), marked("ride a fish")),
        (("follow",), marked("follow a fish")),
        (("reins",), marked("steer the fish")),
        (("look",), marked("what its eyes see")),
        (("alight",), marked("leave the fish")),
        (("feed",), marked("feed the fishes")),
        (("desk",), marked("panels")),
    )),
    (marked("Time"), (
        (("pause",), marked("stand still, go on")),
        (("rewind",), marked("a second back")),
        (("tick",), marked("one step on")),
        (("slower", "faster"), marked("slower, faster")),
    )),
    (marked("Pictures"), (
        (("picture",), marked("take a picture")),
        (("photo",), marked("photo mode")),
        (("film",), marked("begin and end a film")),
        (("quality",), marked("quality")),
        (("fullscreen",), marked("full screen")),
        (("instruments",), marked("instruments")),
        (("pattern",), marked("test pattern")),
    )),
    (marked("Sound"), (
        (("mute",), marked("sound off, on")),
        (("quieter", "louder"), marked("softer, louder")),
        (("score",), marked("quiet score")),
    )),
    (marked("More"), (
        (("menu",), marked("menu")),
        (("language",), marked("language")),
        (("cue",), marked("next item of the show")),
        (("help",), marked("this help")),
        (("leave",), marked("end the dive")),
    )),
)  # fmt: skip
"""All controls, by what they are for."""
GREETING: tuple[tuple[Pair, ...], ...] = (
    ((("follow",), marked("follow a fish")), (("reins",), marked("steer it"))),
    ((("help",), marked("all keys")), (("menu",), marked("menu"))),
)
WORN = (
    marked(
        "left stick: go and turn, triggers: rise and dive; without sticks, point and pull the "
        "trigger"
    ),
    marked("A: stop, Y: ride a fish, B: leave it, menu button: menu"),
)
"""The lines for a new visitor in a headset."""
NOT_SHARED: tuple[ControlName, ...] = ("follow", "ride", "reins", "feed", "desk")
"""Controls without a function where several computers show the dive."""


class Row(NamedTuple):
    """Keys, and their function."""

    keys: tuple[str, ...]
    what: str


class HelpContent(NamedTuple):
    """Texts of the help, in the language of visitors."""

    left: str  # function of the left mouse button
    right: str
    wheel: str
    moving: str
    both: str
    groups: tuple[tuple[str, tuple[Row, ...]], ...]  # titles, and controls that have keys
    brief: tuple[tuple[Row, ...], ...]  # lines for a new visitor


def help_content(
    bindings: Bindings,
    steers: bool = True,
    without: Sequence[ControlName] = (),
    worn: bool = False,
) -> HelpContent:
    """The help for these bindings; the pointer `steers`.

    `without`: unavailable controls; `worn`: for a visitor in a headset.
    """
    left, right, middle = (
        BESIDE_MOUSE.get(control, "") if (control := bindings.control(f"mouse {name}")) else ""
        for name in ("left", "right", "middle")
    )
    lifts = {left, right} == {"ahead", "back"} and steers
    if left == "ahead" and steers:
        first = [Row((), translated("point where to look, hold the left button to go there"))]
    else:
        first = _rows(bindings, GROUPS[0][1][:2], without)
    greeting = [first, *(_rows(bindings, line, without) for line in GREETING)]
    if worn:
        greeting = [[Row((), translated(line))] for line in WORN]
    wheel = marked("wheel: speed, press: {action}") if middle else marked("wheel: speed")
    return HelpContent(
        translated(left),
        translated(right),
        translated(wheel).format(action=translated(middle)),
        translated("move: look and turn") if steers else "",
        translated("hold both and move: rise, dive") if lifts else "",
        tuple(
            (translated(title), tuple(rows))
            for title, pairs in GROUPS
            if (rows := _rows(bindings, pairs, without))
        ),
        tuple(tuple(line) for line in greeting if line),
    )


def _rows(
    bindings: Bindings,
    pairs: Sequence[Pair],
    without: Sequence[ControlName],
) -> list[Row]:
    """The rows of controls that have keys, and are available."""
    rows = []
    for controls, what in pairs:
        keys = tuple(key for control in controls if (key := _key(bindings, control)))
        if keys and not set(controls) & set(without):
            rows.append(Row(keys, translated(what)))
    return rows


def draw_brief(content: HelpContent, opacity: float) -> None:
    """Draw the lines for a new visitor at the upper left of the current frame."""
    line = imgui.get_font_size()
    canvas, left, top = imgui.get_background_draw_list(), 1.6 * line, 1.2 * line
    wide = max((sum(_part_width(row, line) for row in rows) for rows in content.brief), default=0.0)
    foot = top + BRIEF_ROW * len(content.brief) * line
    draw_backing((left, top), (left + wide - BRIEF_GAP * line, foot), line, opacity)
    for number, rows in enumerate(content.brief):
        x, y = left, top + (BRIEF_ROW * number + (BRIEF_ROW - CAP) / 2) * line
        for row in rows:
            after = x + _part_width(row, line)
            for key in row.keys:
                x += _cap(canvas, key, x, y, line, opacity) + 0.3 * line
            draw_shadowed_text((x, y + (CAP - 1.0) / 2 * line), row.what, line, INK, opacity)
            x = after


def _part_width(row: Row, line: float) -> float:
    """Width of keys, their function and the gap after it."""
    keys = sum(_cap_width(key, line) + 0.3 * line for key in row.keys)
    return keys + float(imgui.calc_text_size(row.what).x) + BRIEF_GAP * line


def draw_help(content: HelpContent, opacity: float, foot: float) -> None:
    """Draw it in the middle of the current frame, its lower edge at `foot` or higher."""
    size, line = imgui.get_io().display_size, imgui.get_font_size()
    layouts = [_layout(columns_of(content.groups, most), line) for most in range(2, COLUMNS + 1)]
    room = [
        min(line, foot / (layout.high + 1.0), size.x / (layout.wide + 1.0)) for layout in layouts
    ]
    line = max(room)
    columns, widths, wide, high = layouts[room.index(line)]
    if line < 1.0:
        return  # the window is too small for any letter
    canvas = imgui.get_background_draw_list()
    x, y = (size.x - wide * line) / 2, max((foot - high * line) / 2, 0.5 * line)
    canvas.add_rect_filled(
        (x, y),
        (x + wide * line, y + high * line),
        colour(GLASS, ground(0.72) * opacity),
        0.6 * line,
    )
    _mouse(canvas, content, x + MOUSE_WIDE / 2 * line, y + MARGIN * line, line, opacity)
    left = x + MOUSE_WIDE * line
    for column, (keys, words) in zip(columns, widths, strict=True):
        top = y + MARGIN * line
        for title, rows in column:
            draw_shadowed_text((left, top), title, line, MARK, opacity)
            top += ROW * line
            for row in rows:
                at = left
                for key in row.keys:
                    at += _cap(canvas, key, at, top, line, opacity) + 0.3 * line
                place = left + keys * line, top + (CAP - 1.0) / 2 * line
                draw_shadowed_text(place, row.what, line, INK, opacity)
                top += ROW * line
            top += GAP * line
        left += words * line


Group = tuple[str, tuple[Row, ...]]


class HelpLayout(NamedTuple):
    """Columns of keys, and the room that the help takes, in heights of letters."""

    columns: list[list[Group]]
    widths: list[tuple[float, float]]  # of each: see `column_width`
    wide: float
    high: float


def _layout(columns: list[list[Group]], line: float) -> HelpLayout:
    """Measure the help with these columns beside the mouse."""
    widths = [column_width(column, line) for column in columns]
    high = max([MOUSE_HIGH, *(_rows_high(column) for column in columns)]) + 2.0 * MARGIN
    wide = MOUSE_WIDE + sum(words for _, words in widths) + MARGIN
    return HelpLayout(columns, widths, wide, high)


def columns_of(groups: Sequence[Group], number: int) -> list[list[Group]]:
    """Divide groups, in their order, among at most `number` columns of about equal height."""
    most = max((1 + len(rows) for _, rows in groups), default=1)
    while True:
        columns: list[list[Group]] = [[]]
        for group in groups:
            if columns[-1] and _rows_high([*columns[-1], group]) > ROW * most:
                columns.append([])
            columns[-1].append(group)
        if len(columns) <= number:
            return columns
        most += 1


def _rows_high(column: Sequence[Group]) -> float:
    """Height of a column, in heights of letters."""
    return sum(ROW * (1 + len(rows)) + GAP for _, rows in column) - GAP


def column_width(column: Sequence[Group], line: float) -> tuple[float, float]:
    """Measure where the texts of a column begin, and its width, in heights of letters.

    Long names of keys and long texts of a language make it wider.
    """
    rows = [row for _, rows in column for row in rows]
    keys = max(sum(_cap_width(key, line) + 0.3 * line for key in row.keys) for row in rows)
    texts = max(float(imgui.calc_text_size(row.what).x) for row in rows)
    return keys / line + 0.3, (keys + texts) / line + 0.3 + 2.0 * MARGIN


def _mouse(
    canvas: Any, content: HelpContent, x: float, y: float, line: float, opacity: float
) -> None:
    """Draw a mouse from above, its middle at x, with labels."""
    wide, high = 5.2 * line, 7.6 * line
    top = y + 3.3 * line
    cut = top + 0.42 * high  # lower end of its buttons
    left, right, foot = x - wide / 2, x + wide / 2, top + high
    flags = imgui.ImDrawFlags_
    round_, thick = 2.5 * line, max(0.13 * line, 1.5)
    ink, glow = colour(INK, opacity), colour(LIT, 0.75 * opacity)
    canvas.add_rect_filled((left, top), (right, foot), colour(GLASS, 0.6 * opacity), round_)
    for lit, begin, end, corner in (
        (content.left, left, x, flags.round_top_left),
        (content.right, x, right, flags.round_top_right),
    ):
        if lit:
            canvas.add_rect_filled((begin, top), (end, cut), glow, round_, corner.value)
    canvas.add_rect((left, top), (right, foot), ink, round_, thick)
    canvas.add_line((left, cut), (right, cut), ink, thick)
    canvas.add_line((x, top), (x, cut), ink, thick)
    canvas.add_rect_filled(
        (x - 0.38 * line, top + 0.7 * line), (x + 0.38 * line, top + 2.2 * line), ink, 0.38 * line
    )
    beside, gap = top + 1.3 * line, 0.7 * line
    for place, text, share in (
        (left - gap, content.left, 1.0),
        (right + gap, content.right, 0.0),
    ):
        if text not in ("", translated(BESIDE_MOUSE["full stop"])):
            hold = translated("hold:")
            draw_shadowed_text((place, beside - line), hold, 0.85 * line, QUIET, opacity, share)
        draw_shadowed_text((place, beside), text, 1.1 * line, INK, opacity, share)
    draw_shadowed_text((x, y + 1.5 * line), content.wheel, line, INK, opacity, 0.5)
    if content.moving:
        middle = cut + 0.5 * (foot - cut)
        for way in ARROWS.values():
            _arrow(canvas, x + 1.15 * way[0] * line, middle + 1.15 * way[1] * line, way, line, ink)
        draw_shadowed_text((x, foot + 0.55 * line), content.moving, 1.15 * line, INK, opacity, 0.5)
    draw_shadowed_text((x, foot + 2.0 * line), content.both, 0.85 * line, QUIET, opacity, 0.5)


def _cap(canvas: Any, key: str, x: float, y: float, line: float, opacity: float) -> float:
    """Draw a key with its name; returns its width."""
    wide = _cap_width(key, line)
    corners = (x, y), (x + wide, y + CAP * line)
    canvas.add_rect_filled(*corners, colour(INK, 0.14 * opacity), 0.25 * line)
    canvas.add_rect(*corners, colour(INK, ground(0.5) * opacity), 0.25 * line, stroke(1.0))
    middle = x + wide / 2, y + CAP / 2 * line
    if key in ARROWS:
        _arrow(canvas, *middle, ARROWS[key], 0.8 * line, colour(INK, opacity))
    else:
        words = key_words(key)
        draw_shadowed_text(
            (middle[0], middle[1] - 0.4 * line), words, 0.8 * line, INK, opacity, 0.5
        )
    return wide


def _cap_width(key: str, line: float) -> float:
    imgui.push_font(None, 0.8 * line)
    text = float(imgui.calc_text_size(key_words(key)).x)
    imgui.pop_font()
    return CAP * line if key in ARROWS else max(CAP * line, text + 0.7 * line)


def _arrow(
    canvas: Any, x: float, y: float, way: tuple[float, float], line: float, ink: int
) -> None:
    """Draw a triangle at (x, y) that points along `way`."""
    (dx, dy), long, half = way, 0.34 * line, 0.36 * line
    canvas.add_triangle_filled(
        (x + long * dx, y + long * dy),
        (x - long * dx - half * dy, y - long * dy + half * dx),
        (x - long * dx + half * dy, y - long * dy - half * dx),
        ink,
    )


def _key(bindings: Bindings, control: ControlName) -> str:
    """The first key of a control; "" if only the mouse or a gamepad has it."""
    return next(
        (name for name in bindings.inputs(control) if not name.startswith(("mouse ", "pad "))), ""
    )
