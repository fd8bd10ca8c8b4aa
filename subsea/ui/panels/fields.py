"""Draw rows of choices, sliders and tables of a scenario in panels, and give panels the dive."""

from collections.abc import Callable, Iterable
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import msgspec
from imgui_bundle import imgui
from msgspec import inspect

from subsea.ui.gui import CLAMP

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

T = TypeVar("T")
Table = TypeVar("Table", bound=msgspec.Struct)

Area = tuple[float, float, float, float]  # left, top, width, height on the screen

WIDE = 11.0  # of a field, in heights of letters
UNITS = {"cm": "cm", "deg": "°", "s": "s", "cm_s": "cm/s", "per_s": "1/s"}


class PanelContext:
    """The interface of a panel to the world, used within a frame of the gui.

    Changes act at once; a replacement of the world waits until after the frame.
    """

    def __init__(self, dive: "Dive") -> None:
        self.dive = dive
        self.chosen: int | None = None  # the fish that panels are about
        self.dragging = False  # the pointer drags something other than a fish
        # The chosen thing or fish, and its area on the screen, which panels do not cover.
        self.subject: tuple[object, Area | None] | None = None
        self._changed = False
        self._after_frame: list[Callable[[], object]] = []
        self._states: dict[type, Any] = {}

    def state(self, kind: type[T]) -> T:
        """The object of this class that a panel keeps from frame to frame; made on first use."""
        return self._states.setdefault(kind, kind())

    def changed(self) -> None:
        """Report a change to the world between two ticks, so that time can go back to it."""
        self._changed = True

    def later(self, act: Callable[[], object]) -> None:
        """Call it after the current frame."""
        self._after_frame.append(act)


class Slider(NamedTuple):
    """A slider for a value."""

    name: str  # of the value
    label: str
    low: float
    high: float
    form: str
    flags: int = CLAMP
    meaning: str = ""  # shown when the pointer rests on it

    def draw(self, value: float) -> float | None:
        """Draw it; return the value that it was moved to, as precisely as shown, or None."""
        moved, value = imgui.slider_float(
            self.label, value, self.low, self.high, self.form, self.flags
        )
        if self.meaning:
            imgui.set_item_tooltip(self.meaning)
        return float(self.form % value) if moved else None


def radio_row(choices: Iterable[tuple[str, T]], chosen: T) -> T | None:
    """Draw a row of choices, one of them `chosen`; return the one that was clicked, or None."""
    clicked = None
    for text, value in choices:
        if imgui.radio_button(text, value == chosen):
            clicked = value
        imgui.same_line()
    imgui.new_line()
    return clicked


class Edit(NamedTuple):
    """A value after this frame's input."""

    value: Any
    settled: bool  # the input is complete


def table(struct: Table) -> tuple[Table, bool]:
    """Draw a field for each key of a table.

    Returns the table, and whether an input is complete: it changes before that in a drag.
    """
    settled = False
    for field in _fields(type(struct)):
        was = getattr(struct, field.name)
        edit = _any(label(field.name), was, field.type)
        settled |= edit.settled
        if edit.value != was:
            struct = msgspec.structs.replace(struct, **{field.name: edit.value})
    return struct, settled


def label(key: str) -> str:
    """A key as a label: its unit last."""
    for unit, sign in sorted(UNITS.items(), key=lambda pair: -len(pair[0])):
        if key.endswith(f"_{unit}"):
            return f"{key.removesuffix(f'_{unit}').replace('_', ' ')}, {sign}"
    return key.replace("_", " ")


def choice(name: str, value: str, choices: list[str]) -> Edit:
    """One of several words."""
    _narrow()
    now = choices.index(value) if value in choices else -1
    changed, number = imgui.combo(name, now, [word.replace("_", " ") for word in choices])
    return Edit(choices[number] if changed else value, changed)


def whole(name: str, value: int, low: int, high: int) -> Edit:
    """A whole number with buttons for the next ones, clamped to its limits."""
    _narrow()
    number = typed_whole(name, value, low, high)
    return Edit(number, imgui.is_item_deactivated_after_edit())


def typed_whole(name: str, value: int, low: int, high: int, step: int = 1) -> int:
    """A field for a whole number, of the width set before.

    Stored as a double, because fields of whole numbers end at 2³¹, below the largest seed.
    """
    changed, entered = imgui.input_double(name, value, step, 0.0, "%.0f")
    return round(min(max(entered, low), high)) if changed else value


def real(
    name: str, value: float, low: float, high: float, per_point: float, form: str = "%.4g"
) -> Edit:
    """A number to drag, by `per_point` a pointer unit, or to type."""
    _narrow()
    _, entered = imgui.drag_float(name, value, per_point, low, high, form, CLAMP)
    return Edit(_short(entered, value), imgui.is_item_deactivated_after_edit())


def _narrow() -> None:
    imgui.set_next_item_width(WIDE * imgui.get_font_size())


def _short(entered: float, value: float) -> float:
    """Round to six digits what ImGui has stored in single precision."""
    return value if abs(entered - value) <= 1e-6 * abs(value) else float(f"{entered:.6g}")


@cache
def _fields(kind: type[msgspec.Struct]) -> tuple[Any, ...]:
    info = inspect.type_info(kind)
    assert isinstance(info, inspect.StructType)
    return info.fields


def _any(name: str, value: Any, kind: Any) -> Edit:
    """Draw the field for a value of a type; nested lists and tables can only be edited in files."""
    match kind:
        case inspect.Metadata():
            return _any(name, value, kind.type)
        case inspect.UnionType():
            inner = next(
                inner_kind
                for inner_kind in kind.types
                if not isinstance(inner_kind, inspect.NoneType)
            )
            return _perhaps(name, value, inner)
        case inspect.BoolType():
            changed, value = imgui.checkbox(name, value)
            return Edit(value, changed)
        case inspect.IntType():
            low, high = _limits(kind)
            return whole(name, value, int(low), int(high))
        case inspect.FloatType():
            low, high = _limits(kind)
            step = 0.004 if high <= 5 else 0.02 if high <= 20 else 1.0
            return real(name, value, low, high, step)
        case inspect.LiteralType():
            return choice(name, value, [str(word) for word in kind.values])
        case inspect.TupleType():
            return _tuple(name, value, kind)
    return Edit(value, False)


def _perhaps(name: str, value: Any, kind: Any) -> Edit:
    """An optional value: a checkbox before it."""
    changed, given = imgui.checkbox(f"##{name}", value is not None)
    imgui.same_line()
    if changed:
        return Edit(_least(kind) if given else None, True)
    if value is None:
        imgui.text_disabled(name)
        return Edit(value, False)
    return _any(name, value, kind)


def _least(kind: Any) -> Any:
    """A first value of a type."""
    match kind:
        case inspect.Metadata():
            return _least(kind.type)
        case inspect.TupleType():
            return tuple(_least(item) for item in kind.item_types)
        case inspect.LiteralType():
            return kind.values[0]
        case inspect.BoolType():
            return True
        case inspect.FloatType():
            low, high = _limits(kind)
            return min(max(low, 0.0), high)
    return 0


def _limits(kind: Any) -> tuple[float, float]:
    low = kind.ge if kind.ge is not None else kind.gt
    high = kind.le if kind.le is not None else kind.lt
    low, high = (-1e5 if low is None else low), (1e5 if high is None else high)
    if kind.gt is not None and isinstance(kind, inspect.FloatType):
        low += 1e-3 * min(1.0, high - low)
    return low, high


def _tuple(name: str, value: tuple[float, ...], kind: Any) -> Edit:
    """Two or three numbers, side by side."""
    item = kind.item_types[0]
    low, high = _limits(item.type if isinstance(item, inspect.Metadata) else item)
    _narrow()
    drag = imgui.drag_float2 if len(value) == 2 else imgui.drag_float3
    step = 0.004 if high <= 1 else 1.0
    _, entered = drag(name, list(value), step, low, high, "%.4g", CLAMP)
    new = tuple(_short(number, old) for number, old in zip(entered, value, strict=True))
    return Edit(new, imgui.is_item_deactivated_after_edit())
