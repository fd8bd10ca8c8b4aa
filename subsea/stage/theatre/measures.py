"""The measures that a new theatre needs: options of the command line, and questions."""

from argparse import ArgumentTypeError
from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

from subsea.base.command_line import NumberReader, number_reader
from subsea.base.errors import UserError, unknown

KINDS = {
    "wall": "a flat wall, projectors side by side",
    "curved": "a part of a cylinder around the audience, projectors side by side",
    "dome": "a dome, projectors at its rim",
    "cave": "a room of flat screens, one projector each",
    "mirror": "a dome, one projector onto a convex mirror",
}


class RoomMeasure(NamedTuple):
    """A measure, with its default for each kind of theatre that needs it."""

    name: str
    text: str
    reader: NumberReader
    defaults: Mapping[str, float]


_whole, _real = partial(number_reader, int), partial(number_reader, float)
LENGTH = _real(10, 10_000)
MEASURES = (
    RoomMeasure("projectors", "number of projectors", _whole(1, 32),
                {"wall": 3, "curved": 3, "dome": 6, "cave": 3}),
    RoomMeasure("across", "width of a projector's picture in pixels", _whole(320, 16384),
                dict.fromkeys(KINDS, 1920)),
    RoomMeasure("down", "height of a projector's picture in pixels", _whole(240, 16384),
                dict.fromkeys(KINDS, 1080)),
    RoomMeasure("overlap", "overlap of neighbours, percent of a picture", _real(2, 40),
                {"wall": 15, "curved": 15, "dome": 10}),
    RoomMeasure("width", "width of the screen in cm", LENGTH, {"wall": 600, "cave": 250}),
    RoomMeasure("height", "height of the screen in cm", LENGTH, {"curved": 140, "cave": 250}),
    RoomMeasure("radius", "radius of the screen in cm", LENGTH,
                {"curved": 275, "dome": 400, "mirror": 300}),
    RoomMeasure("angle", "angle of the screen from left to right in degrees", _real(30, 300),
                {"curved": 120}),
    RoomMeasure("distance", "distance of the best seat from the wall in cm", LENGTH, {"wall": 400}),
    RoomMeasure("bottom", "height of the screen's lower edge above the floor in cm",
                _real(0, 10_000), {"wall": 60, "curved": 50}),
    RoomMeasure("eye", "height of the audience's eyes above the floor in cm", _real(30, 1000),
                dict.fromkeys(KINDS, 120)),
    RoomMeasure("tilt", "tilt of the dome to the front in degrees", _real(0, 60),
                {"dome": 0, "mirror": 0}),
    RoomMeasure("mirror", "radius of the mirror's sphere in cm", _real(5, 500), {"mirror": 30}),
    RoomMeasure("throw", "throw ratio of the lenses, distance over width; 0: one that fits",
                _real(0, 20), {"wall": 1.2, "curved": 0, "dome": 0, "mirror": 1.5}),
)  # fmt: skip


def chosen(kind: str, given: Mapping[str, float | None]) -> dict[str, float]:
    """The measures of a kind: those given, else the defaults; UserError for a foreign one."""
    if kind not in KINDS:
        raise unknown("kind of theatre", kind, list(KINDS))
    fitting = {measure.name: measure for measure in MEASURES if kind in measure.defaults}
    values = {name: value for name, value in given.items() if value is not None}
    if foreign := [name for name in values if name not in fitting]:
        options = ", ".join(f"--{name}" for name in fitting)
        raise UserError(f"--{foreign[0]} is not for a {kind}, expected {options}")
    return {name: measure.defaults[kind] for name, measure in fitting.items()} | values


def ask(
    given: Mapping[str, float | None],
    read: Callable[[str], str],
    tell: Callable[[str], object],
    kind: str | None = None,
) -> tuple[str, dict[str, float]]:
    """Ask for the kind and for each measure that is not given; an empty answer is the default.

    `read` shows a question and returns a line, `tell` shows why an answer does not fit.
    """
    while kind not in KINDS:
        if kind:
            tell(str(unknown("kind of theatre", kind, list(KINDS))))
        kind = read(f"kind of theatre ({', '.join(KINDS)}) [wall]: ").strip() or "wall"
    measures = chosen(kind, given)
    for question in MEASURES:
        if kind in question.defaults and given.get(question.name) is None:
            measures[question.name] = _answer(question, question.defaults[kind], read, tell)
    return kind, measures


def _answer(
    question: RoomMeasure,
    default: float,
    read: Callable[[str], str],
    tell: Callable[[str], object],
) -> float:
    """The answer to one question, asked until it fits."""
    while True:
        text = read(f"{question.text} [{default:g}]: ").strip()
        if not text:
            return default
        try:
            return question.reader(text)
        except ArgumentTypeError as fault:
            tell(str(fault))
