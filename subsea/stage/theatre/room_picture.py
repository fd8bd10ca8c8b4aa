"""A picture of a theatre: room, screens, projectors and eye from above, from the side, aslant."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from subsea.base.arrays import Array, Bytes
from subsea.stage.theatre.channels import ProjectorChannel
from subsea.stage.theatre.screens import points_on
from subsea.stage.theatre.theatre_file import Room, Theatre
from subsea.view.camera import axes_of
from subsea.view.rig import Projection
from subsea.view.test_pattern import colour_of

SIZE = 1500, 620  # pixels
FINER = 2  # times more pixels while drawing
PAPER, INK, FAINT, EYE = (250, 250, 247), (40, 44, 50), (205, 207, 210), (200, 30, 40)
EDGE = np.linspace(0.0, 1.0, 25)
ROUND = np.linspace(0.0, 2.0 * math.pi, 73)
RIM = np.stack([np.cos(ROUND), np.zeros_like(ROUND), np.sin(ROUND)], axis=1)
# Rows: right and up on the paper, for points right, up, ahead.
VIEWS = {
    "from above": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "from the right side": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
    "aslant": axes_of(math.radians(28.0), math.radians(-24.0))[:2],
}
STEPS_CM = 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 100_000  # of the scale bar


class RoomLine(NamedTuple):
    """A line through points of the room."""

    points: Array  # (n, 3) cm
    colour: tuple[int, int, int]
    wide: float = 1.0  # pixels


def room_picture(theatre: Theatre, channels: Sequence[ProjectorChannel]) -> Bytes:
    """The picture (h, w, 3) of a theatre and its working channels."""
    strokes = list(_strokes(theatre, channels))
    lenses = dict(theatre.room.projectors) if theatre.room else {}
    width, height = SIZE[0] * FINER, SIZE[1] * FINER
    picture = Image.new("RGB", (width, height), PAPER)
    draw = ImageDraw.Draw(picture)
    line = 15.0 * FINER
    _text(draw, (line, 0.6 * line), theatre.title or "A theatre", 1.3 * line)
    top, foot = round(3.4 * line), height - round(2.2 * line)
    wide = width // len(VIEWS)
    everything = np.concatenate([stroke.points for stroke in strokes])
    scale = min(_scale(everything @ axes.T, wide - 3 * line, foot - top) for axes in VIEWS.values())
    for k, (name, axes) in enumerate(VIEWS.items()):
        flat = everything @ axes.T
        middle = (flat.min(axis=0) + flat.max(axis=0)) / 2.0
        origin = np.array([(k + 0.5) * wide, (top + foot) / 2.0])

        def place(points: Array, axes: Array = axes, middle: Array = middle,
                  origin: Array = origin) -> list[tuple[float, float]]:  # fmt: skip
            flat = (np.atleast_2d(points) @ axes.T - middle) * scale * [1.0, -1.0] + origin
            return [(float(x), float(y)) for x, y in flat]

        for stroke in strokes:
            draw.line(place(stroke.points), stroke.colour, round(stroke.wide * FINER), "curve")
        for number, one in enumerate(channels):
            if one.name in lenses:
                ((x, y),) = place(np.array(lenses[one.name]))
                box = [x - 0.35 * line, y - 0.35 * line, x + 0.35 * line, y + 0.35 * line]
                draw.rectangle(box, colour_of(number + 1), INK, FINER)
            ((x, y),) = place(_middle(theatre, one))
            _text(draw, (x, y), str(number + 1), line, "mm")
        ((x, y),) = place(np.array(theatre.eye_cm))
        draw.ellipse([x - 0.4 * line, y - 0.4 * line, x + 0.4 * line, y + 0.4 * line], EYE)
        _text(draw, (k * wide + line, 2.4 * line), name, 0.9 * line)
    _scale_bar(draw, scale, (line, height - 1.1 * line), line)
    legend = ["red dot: best seat"] + ["squares: lenses"] * bool(lenses)
    legend += [f"{k + 1} {one.name}" for k, one in enumerate(channels)][:12]
    _text(draw, (width * 0.25, height - 1.7 * line), ", ".join(legend), 0.9 * line)
    return np.asarray(picture.resize(SIZE, Image.Resampling.LANCZOS))


def _strokes(theatre: Theatre, channels: Sequence[ProjectorChannel]) -> Iterator[RoomLine]:
    """Floor, dome, mirror, screens, their light and the sight lines, the farthest first."""
    room, eye = theatre.room or Room(), np.array(theatre.eye_cm)
    edges = [_edge(theatre, one) for one in channels]
    whole = np.concatenate([eye[None], *edges, *(np.array([p]) for p in room.projectors.values())])
    if room.floor_cm is not None:
        (left, _, back), (right, _, front) = whole.min(axis=0) - 20.0, whole.max(axis=0) + 20.0
        y = room.floor_cm
        corners = [(left, y, back), (right, y, back), (right, y, front), (left, y, front)]
        yield RoomLine(np.array([*corners, corners[0]]), FAINT, 2.0)
        yield RoomLine(np.array([eye, [eye[0], y, eye[2]]]), EYE, 1.0)
    if room.dome is not None:
        yield from _dome(eye, room.dome.distance_cm, room.dome.tilt_deg)
    for number, (one, edge) in enumerate(zip(channels, edges, strict=True), 1):
        colour = colour_of(number)
        pale = tuple((3 * p + c) // 4 for p, c in zip(PAPER, colour, strict=True))
        for corner in edge[:: max(len(edge) // 4, 1)][:4]:
            yield RoomLine(np.array([eye, corner]), FAINT)
            if one.name in room.projectors:
                lens = np.array(room.projectors[one.name])
                way = [lens, corner]
                if room.mirror is not None:
                    way = [lens, np.array(room.mirror.centre_cm), corner]
                yield RoomLine(np.array(way), (pale[0], pale[1], pale[2]), 1.5)
        yield RoomLine(edge, (colour[0] * 3 // 4, colour[1] * 3 // 4, colour[2] * 3 // 4), 3.0)
    if room.mirror is not None:
        for a, b in ((0, 1), (1, 2), (2, 0)):
            ring = np.zeros((len(ROUND), 3))
            ring[:, a], ring[:, b] = np.cos(ROUND), np.sin(ROUND)
            yield RoomLine(np.array(room.mirror.centre_cm) + room.mirror.radius_cm * ring, INK, 1.5)


def _edge(theatre: Theatre, one: ProjectorChannel) -> Array:
    """The closed edge (n, 3) of a channel's screen, real cm."""
    eye, room = np.array(theatre.eye_cm), theatre.room
    far = one.distance_cm / theatre.scale
    if one.screen is not None:
        zero, whole = np.zeros_like(EDGE), np.ones_like(EDGE)
        sides = (EDGE, zero), (whole, EDGE), (EDGE[::-1], whole), (zero, EDGE[::-1])
        places = np.concatenate([np.column_stack(side) for side in sides])
        points = points_on(one.screen, places) / theatre.scale
        if room is not None and room.dome is not None:
            points *= room.dome.distance_cm / np.linalg.norm(points, axis=1, keepdims=True)
        return np.asarray(eye + points)
    if one.shape == Projection.DOME:
        return np.asarray(eye + far * RIM @ axes_of(0.0, -one.surround.wide[1]))
    half = one.surround.wide[0] / 2.0 if one.shape == Projection.PANORAMA else math.pi
    turn = np.linspace(-half, half, 49)
    tall = 2.0 * half * one.place[3] / one.place[2] / 2.0
    arc = np.stack([np.sin(turn), np.zeros_like(turn), np.cos(turn)], axis=1)
    rise = np.array([0.0, min(tall, 1.0), 0.0])
    return np.asarray(eye + far * np.concatenate([arc - rise, arc[::-1] + rise, arc[:1] - rise]))


def _middle(theatre: Theatre, one: ProjectorChannel) -> Array:
    """The place (3,) of a channel's number."""
    edge = _edge(theatre, one)
    if one.screen is None and one.shape != Projection.DOME:
        eye = np.array(theatre.eye_cm)
        return np.asarray(eye + [0.0, 0.0, one.distance_cm / theatre.scale])
    return np.asarray((edge.min(axis=0) + edge.max(axis=0)) / 2.0)


def _dome(eye: Array, radius: float, tilt_deg: float) -> Iterator[RoomLine]:
    """The rim and the meridians of a dome about the eye."""
    axes = axes_of(0.0, -math.radians(tilt_deg))
    yield RoomLine(eye + radius * RIM @ axes, INK, 2.0)
    half = ROUND[: len(ROUND) // 2 + 1]
    for turn in np.radians([0.0, 45.0, 90.0, 135.0]):
        flat = np.cos(half)
        arch = np.stack([flat * np.sin(turn), np.sin(half), flat * np.cos(turn)], axis=1)
        yield RoomLine(eye + radius * arch @ axes, FAINT, 1.5)


def _scale(flat: Array, wide: float, high: float) -> float:
    """Pixels per centimetre at which points (n, 2) fit."""
    across, up = np.maximum(flat.max(axis=0) - flat.min(axis=0), 1.0)
    return float(min(wide / across, high / up))


def _scale_bar(
    draw: ImageDraw.ImageDraw, scale: float, place: tuple[float, float], line: float
) -> None:
    """A bar of a round length, and that length."""
    length = next((cm for cm in STEPS_CM if cm * scale > 4 * line), STEPS_CM[-1])
    x, y = place
    draw.line([(x, y), (x + length * scale, y)], INK, 2 * FINER)
    for end in (x, x + length * scale):
        draw.line([(end, y - 0.3 * line), (end, y + 0.3 * line)], INK, 2 * FINER)
    words = f"{length / 100:g} m" if length >= 100 else f"{length} cm"
    _text(draw, (x + length * scale + 0.6 * line, y), words, 0.9 * line, "lm")


def _text(
    draw: ImageDraw.ImageDraw, place: tuple[float, float], text: str, tall: float,
    anchor: str = "la",
) -> None:  # fmt: skip
    font = ImageFont.load_default(tall)
    draw.text(place, " ".join(text.split()), INK, font, anchor, stroke_width=FINER,
              stroke_fill=PAPER)  # fmt: skip
