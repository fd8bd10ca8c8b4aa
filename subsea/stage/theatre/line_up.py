"""Line-up on the wall: what people at a console change of a theatre's projectors, and its history.

It knows no dive. `LineUpState` is what all computers of the dive show.
"""

import time
from collections.abc import Callable, Sequence
from typing import Annotated, Any, Literal, NamedTuple, get_args

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from subsea.base.errors import UserError, unknown
from subsea.base.validation import convert
from subsea.stage.theatre.adjusting import moved_places, patch_adjustment, tidy
from subsea.stage.theatre.theatre_file import MOST_POINTS, Adjustment, Corners, PointRow
from subsea.view.adjustment import resampled

Pattern = Literal["sea", "grid", "white", "grey", "black"]
Others = Literal["full", "dim", "black"]
ChannelName = Annotated[str, Meta(min_length=1, max_length=256)]
Adjustments = dict[ChannelName, Adjustment]

Side = Annotated[int, Meta(ge=2, le=MOST_POINTS)]

CORNERS = ("upper_left", "upper_right", "lower_right", "lower_left")  # clockwise
GRID = (4, 4)  # columns and rows of points, where the file has none
GESTURE_S = 1.0  # moves of a point that follow each other sooner are undone together
MOST_UNDO = 1000
DIGITS = 3  # of pixels, after the point


class LineUpState(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The line-up of a theatre, as all its computers show it."""

    adjustments: Adjustments = {}  # of the channels that were changed since the start of the dive
    saved: Adjustments = {}  # for the theatre file of every computer
    open: bool = False  # True: patterns and marks are shown
    pattern: Pattern = "grid"
    others: Others = "dim"  # how the channels that are not chosen are shown
    channel: Annotated[str, Meta(max_length=256)] = ""  # that is chosen
    point: Annotated[str, Meta(max_length=20)] = ""  # that is chosen: see `point_names`
    grid: tuple[Side, Side] = GRID  # columns and rows of the points of that channel


NOTHING_CHANGED = LineUpState()


class LineUpChannel(NamedTuple):
    """A channel as its theatre file has it, in pixels of that file."""

    name: str  # no other channel has it
    size: tuple[int, int]  # of its picture, before it is turned
    adjustment: Adjustment = Adjustment()
    node: str = ""  # its computer
    blends: bool = False


def grid_of(adjustment: Adjustment) -> tuple[int, int]:
    """Return columns and rows of the points of an adjustment."""
    points = adjustment.points_px
    return GRID if points is None else (len(points[0]), len(points))


def point_names(adjustment: Adjustment, grid: tuple[int, int]) -> list[str]:
    """Name what can be chosen: corners clockwise, points as ROW,COLUMN, edge:NUMBER; all from 1."""
    columns, rows = grid
    points = [f"{row + 1},{column + 1}" for row in range(rows) for column in range(columns)]
    edges = [f"edge:{number + 1}" for number in range(len(adjustment.edge_mask or ()))]
    return [*CORNERS, *points, *edges]


def point_places(
    adjustment: Adjustment, size: tuple[int, int], grid: tuple[int, int]
) -> dict[str, tuple[float, float]]:
    """Find where corners, points and corners of the edge mask lie, by name.

    The places are shares right and up of the picture of `size` pixels, after its points were moved.
    """
    columns, rows = grid
    x, y = np.meshgrid(np.linspace(0, 1, columns), np.linspace(1, 0, rows))
    corners = np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
    places = np.concatenate([corners, np.stack([x, y], axis=-1).reshape(-1, 2)])
    found = moved_places(adjustment, size, places).tolist()
    found += [(right / size[0], 1.0 - down / size[1]) for right, down in adjustment.edge_mask or ()]
    names = point_names(adjustment, grid)
    return {name: (place[0], place[1]) for name, place in zip(names, found, strict=True)}


class LineUp:
    """The line-up of the channels of a theatre, with undo; everybody at the console shares it."""

    def __init__(
        self, channels: Sequence[LineUpChannel], clock: Callable[[], float] = time.monotonic
    ) -> None:
        """`clock` gives the time, s."""
        self.state = NOTHING_CHANGED
        self._channels = {channel.name: channel for channel in channels}
        self._file = {name: channel.adjustment for name, channel in self._channels.items()}
        self._now = dict(self._file)
        self._kept = dict(self._file)  # as the theatre file has it
        self._grids = {name: grid_of(one) for name, one in self._file.items()}
        self._before = False  # True: what the theatre file has is shown for comparison
        self._undo: list[Adjustments] = []
        self._redo: list[Adjustments] = []
        self._clock, self._gesture, self._moved_s = clock, ("", ""), -np.inf

    def begin(self) -> str:
        """Show patterns and marks."""
        channel = self.state.channel or next(iter(self._channels))
        point = self.state.point or CORNERS[0]
        self._publish(open=True, channel=channel, point=point)
        return f"the line-up shows {channel}"

    def cancel(self) -> str:
        """Return to what the theatre file has, and show the sea."""
        if self._now != self._kept:
            self._record()
        self._now, self._before = dict(self._kept), False
        self._publish(open=False)
        return "the projectors are as in the theatre file"

    def choose(self, channel: str = "", point: str = "") -> str:
        """Choose a channel and one of its points by name, or the `next` or `previous` one."""
        self._require_open()
        name = _chosen("channel", channel or self.state.channel, list(self._channels),
                       self.state.channel)  # fmt: skip
        names = point_names(self._now[name], self._grids[name])
        before = self.state.point if self.state.point in names else names[0]
        self._publish(channel=name, point=_chosen("point", point or before, names, before))
        return f"{name}: {self.state.point}"

    def move(self, right: float, down: float) -> str:
        """Move the chosen point by pixels."""
        self._require_open()
        name, point = self.state.channel, self.state.point
        adjustment = self._now[name]
        if point in CORNERS:
            corners = adjustment.corners_px or Corners()
            changed = _plus(getattr(corners, point), right, down)
            self._change(name, "corners_px", replace(corners, **{point: changed}), point)
        elif point.startswith("edge:"):
            edge = list(adjustment.edge_mask or ())
            number = int(point.removeprefix("edge:")) - 1
            edge[number] = _plus(edge[number], right, down)
            self._change(name, "edge_mask", edge, point)
        else:
            row, column = (int(number) - 1 for number in point.split(","))
            points = [list(one) for one in adjustment.points_px or _still(self._grids[name])]
            points[row][column] = _plus(points[row][column], right, down)
            self._change(name, "points_px", points, point)
        return f"{name}: {point} moved"

    def set(self, key: str, value: Any) -> str:
        """Set a key of the chosen channel; None: its default. `grid` takes [columns, rows]."""
        self._require_open()
        name = self.state.channel
        if key == "grid":
            self._set_grid(name, value)
        elif key in Adjustment.__struct_fields__:
            if value is None:
                value = getattr(Adjustment(), key)
            self._change(name, key, value, key)
        else:
            raise unknown("key", key, [*Adjustment.__struct_fields__, "grid"])
        if self.state.point not in point_names(self._now[name], self._grids[name]):
            self._publish(point=CORNERS[0])
        return f"{name}: {key} set"

    def show(self, pattern: str = "", others: str = "") -> str:
        """Choose what is shown, and how the channels that are not chosen are."""
        self._require_open()
        pattern, others = pattern or self.state.pattern, others or self.state.others
        for kind, given, known in (("pattern", pattern, Pattern), ("way", others, Others)):
            if given not in get_args(known):
                raise unknown(kind, given, list(get_args(known)))
        self._publish(pattern=pattern, others=others)
        return f"shows {pattern}, the others {others}"

    def undo(self) -> str:
        """Take the last change back."""
        return self._step(self._undo, self._redo, "nothing to undo", "undone")

    def redo(self) -> str:
        """Make the change again that was taken back last."""
        return self._step(self._redo, self._undo, "nothing to do again", "done again")

    def compare(self, before: bool) -> str:
        """Show what the theatre file has for comparison, or the changes again."""
        self._require_open()
        self._before = before
        self._publish()
        return "as in the theatre file" if before else "as changed"

    def save(self, write: Callable[[Adjustments], object]) -> str:
        """Let `write` put the changes into the theatre file; it may raise a UserError."""
        if self._now == self._kept:
            raise UserError("nothing has changed since the theatre file was read or saved")
        changed = {name: one for name, one in self._now.items() if one != self._file[name]}
        # A channel that was saved and is now again as it was at the start.
        changed |= {name: self._now[name] for name in self.state.saved}
        write(changed)
        self._kept, self._before = dict(self._now), False
        self._publish(saved=changed)
        return "saved into the theatre file"

    @property
    def unsaved(self) -> bool:
        """True if the theatre file lacks a change."""
        return self._now != self._kept

    def describe(self) -> dict[str, Any]:
        """Describe the line-up for the console."""
        name = self.state.channel
        channels = [
            {
                "name": one,
                "number": number,
                "node": self._channels[one].node,
                "changed": self._now[one] != self._kept[one],
            }
            for number, one in enumerate(self._channels, 1)
        ]
        about: dict[str, Any] = {
            "open": self.state.open,
            "channels": channels,
            "channel": name,
            "point": self.state.point,
            "pattern": self.state.pattern,
            "others": self.state.others,
            "before": self._before,
            "undo": len(self._undo),
            "redo": len(self._redo),
            "unsaved": self.unsaved,
        }
        if name:
            adjustment, size = self._now[name], self._size(name)
            places = point_places(adjustment, size, self._grids[name])
            about |= {
                "size": size,
                "grid": self._grids[name],
                "blends": self._channels[name].blends,
                "adjustment": msgspec.to_builtins(adjustment),
                "points": [
                    {"name": one, "x": round(x, 5), "y": round(1.0 - y, 5)}
                    for one, (x, y) in places.items()
                ],
            }
        return about

    def _change(self, name: str, key: str, value: Any, gesture: str) -> None:
        """Set a key of a channel, so that it can be undone; a UserError changes nothing."""
        plain = msgspec.to_builtins(self._now[name])
        plain[key] = msgspec.to_builtins(value)
        adjustment = tidy(convert(plain, Adjustment))
        patch_adjustment(adjustment, self._size(name, adjustment))
        if adjustment == self._now[name]:
            return
        now = self._clock()
        if self._gesture != (name, gesture) or now - self._moved_s > GESTURE_S:
            self._record()
        self._gesture, self._moved_s = (name, gesture), now
        self._now[name], self._before = adjustment, False
        if adjustment.points_px is not None:
            self._grids[name] = grid_of(adjustment)
        self._publish()

    def _set_grid(self, name: str, value: Any) -> None:
        """Take another grid of points, with about the same shifts."""
        columns, rows = convert(value, tuple[Side, Side])
        points = self._now[name].points_px
        if points is not None:
            finer = np.round(resampled(np.array(points), rows, columns), DIGITS)
            self._change(name, "points_px", finer.tolist(), "grid")
        self._grids[name] = columns, rows
        self._publish()

    def _record(self) -> None:
        self._undo.append(dict(self._now))
        del self._undo[:-MOST_UNDO]
        self._redo.clear()
        self._gesture = "", ""

    def _step(self, back: list[Adjustments], ahead: list[Adjustments], none: str, done: str) -> str:
        self._require_open()
        if not back:
            raise UserError(none)
        ahead.append(dict(self._now))
        self._now, self._gesture, self._before = back.pop(), ("", ""), False
        for name, adjustment in self._now.items():
            if adjustment.points_px is not None:
                self._grids[name] = grid_of(adjustment)
        chosen = self.state.channel
        if self.state.point not in point_names(self._now[chosen], self._grids[chosen]):
            self._publish(point=CORNERS[0])
        self._publish()
        return done

    def _publish(self, **changes: Any) -> None:
        """Make the state that all computers show."""
        shown = self._kept if self._before else self._now
        touched = {
            name: one
            for name, one in shown.items()
            if one != self._file[name] or name in self.state.adjustments
        }
        state = replace(self.state, adjustments=touched, **changes)
        self.state = replace(state, grid=self._grids.get(state.channel, GRID))

    def _size(self, name: str, adjustment: Adjustment | None = None) -> tuple[int, int]:
        """Width and height of a channel's picture, before it is turned."""
        channel, now = self._channels[name], adjustment or self._now[name]
        aside = now.rotate % 180 != channel.adjustment.rotate % 180
        return channel.size[::-1] if aside else channel.size

    def _require_open(self) -> None:
        if not self.state.open:
            raise UserError("begin the line-up first: the command `line-up-edit` with `on` true")


def _chosen(kind: str, wanted: str, names: list[str], before: str) -> str:
    """A name, or that after or before another one, in a ring."""
    if wanted in ("next", "previous"):
        step = 1 if wanted == "next" else -1
        return names[(names.index(before) + step) % len(names)]
    if wanted not in names:
        raise unknown(kind, wanted, names)
    return wanted


def _plus(pair: tuple[float, float], right: float, down: float) -> tuple[float, float]:
    return round(pair[0] + right, DIGITS), round(pair[1] + down, DIGITS)


def _still(grid: tuple[int, int]) -> list[PointRow]:
    """Shifts of nothing for a grid of columns and rows."""
    columns, rows = grid
    return [[(0.0, 0.0)] * columns for _ in range(rows)]
