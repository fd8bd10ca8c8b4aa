"""Layouts of screens and projectors for the kinds of theatre.

The eye is at 0; directions are right, up, ahead.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from itertools import combinations
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.stage.theatre import lenses, screens
from subsea.stage.theatre.measured_mesh import heading_pitch_roll
from subsea.stage.theatre.theatre_file import Angles, Cylinder, Dome, Plane, Point, SphericalMirror
from subsea.view.camera import axes_of
from subsea.view.rig import Rect

NODES = 65, 49  # columns and rows of a mesh
ABOVE_CM = 15.0  # a lens stands that much above the edge of a screen
HOUSING_CM = 50.0  # least distance of two lenses
TURNS = [turn for k in range(5, 95, 5) for turn in (k, -k)]  # degrees by which a lens moves aside
RIM = 0.95  # farthest place of a lens in a dome, in radii
RINGS = 9, 20  # numbers of projectors from which a dome has one ring more
LEAST_LIT = 0.3  # share of a projector's pixels that light its part of a screen
STEPS = 40  # places of a lens to try
_T = np.linspace(0.0, 1.0, 33)
_ZERO, _ONE = np.zeros_like(_T), np.ones_like(_T)
_SIDES = (_T, _ZERO), (_T, _ONE), (_ZERO, _T), (_ONE, _T)
_BORDER = np.concatenate([np.column_stack(side) for side in _SIDES])  # places along all edges


class UnlitError(UserError):
    """The error for projectors that would use too few of their pixels."""


class PlannedChannel(NamedTuple):
    """A projector and its screen."""

    name: str
    screen: Plane | Cylinder | Angles | Dome
    lens: lenses.Lens
    nodes: Array | None = None  # (rows, columns, 5) of its mesh
    viewport: Rect | None = None  # in its window, as a theatre file has it; None: all of it


class TheatreLayout(NamedTuple):
    """Projectors and screens of a theatre, and the room for its picture."""

    title: str
    channels: Sequence[PlannedChannel]
    floor_cm: float
    blend: bool = False
    dome: Dome | None = None
    mirror: SphericalMirror | None = None
    notes: Sequence[str] = ()


def layout(kind: str, measures: Mapping[str, float]) -> TheatreLayout:
    """The layout of a kind with its measures; a UserError if it is impossible."""
    makers = {"wall": _wall, "curved": _curved, "dome": _dome, "cave": _cave, "mirror": _mirror}
    try:
        plan = makers[kind](measures)
    except UnlitError as fault:
        turned = {**measures, "across": measures["down"], "down": measures["across"]}
        try:
            makers[kind](turned)
        except UserError:
            raise fault from None
        options = f"--across {turned['across']:g} --down {turned['down']:g}"
        raise UserError(f"{fault}, or pictures turned by a quarter ({options})") from fault
    places = [channel.lens.place for channel in plan.channels]
    gaps = [float(np.linalg.norm(a - b)) for a, b in combinations(places, 2)]
    if gaps and min(gaps) < HOUSING_CM - 0.1:
        note = f"two lenses are {min(gaps):.0f} cm apart: their housings must be narrower"
        return plan._replace(notes=[*plan.notes, note])
    return plan


def front_channel(plan: TheatreLayout) -> PlannedChannel:
    """The channel whose screen is most straight ahead of the best seat."""

    def ahead(channel: PlannedChannel) -> float:
        if isinstance(channel.screen, Dome):
            return 0.0
        screen = screens.screen_of(channel.screen, np.zeros(3), 1.0)
        middle = screens.points_on(screen, np.array([[0.5, 0.5]]))[0]
        return round(float(middle[2] / np.linalg.norm(middle)), 6)

    return max(plan.channels, key=ahead)


def names_of(count: int) -> list[str]:
    """Names of projectors side by side."""
    few = {1: ["middle"], 2: ["left", "right"], 3: ["left", "middle", "right"]}
    return few.get(count) or [f"projector-{k + 1}" for k in range(count)]


def spans(whole: float, count: int, overlap: float) -> list[tuple[float, float]]:
    """Begin and end of `count` equal parts of 0 to `whole` that overlap by a share of a part."""
    part = whole / (count - (count - 1) * overlap)
    step = part * (1.0 - overlap)
    return [(k * step, k * step + part) for k in range(count)]


def _wall(measures: Mapping[str, float]) -> TheatreLayout:
    """Pictures side by side on a wall; lenses with shift, so that no picture is a trapezium."""
    count, width, far = int(measures["projectors"]), measures["width"], measures["distance"]
    aspect, throw = _aspect(measures), measures["throw"] or 1.2
    overlap = measures["overlap"] / 100.0
    parts = spans(width, count, overlap)
    across = parts[0][1] - parts[0][0]
    bottom = measures["bottom"] - measures["eye"]
    top = bottom + across / aspect
    channels = []
    for name, (left, right) in zip(names_of(count), parts, strict=True):
        low, high = left - width / 2.0, right - width / 2.0
        place = np.array([(low + high) / 2.0, top + ABOVE_CM, far - throw * across])
        half = 0.5 / throw, 0.5 / throw / aspect
        plane = Plane(
            lower_left=(low, bottom, far), lower_right=(high, bottom, far),
            upper_left=(low, top, far),
        )  # fmt: skip
        channels.append(PlannedChannel(name, plane, lenses.Lens(place, np.eye(3), half)))
    notes = [
        f"each picture is {across:.0f} x {across / aspect:.0f} cm, "
        f"{overlap * across:.0f} cm of it shared with each neighbour",
        _lens_note(channels),
    ]
    return TheatreLayout(
        f"A flat wall, projectors: {count}", channels, -measures["eye"], True, notes=notes
    )


def _curved(measures: Mapping[str, float]) -> TheatreLayout:
    """Pictures side by side on a cylinder about the best seat."""
    count, radius, angle = int(measures["projectors"]), measures["radius"], measures["angle"]
    bottom = measures["bottom"] - measures["eye"]
    top = bottom + measures["height"]
    overlap = measures["overlap"] / 100.0
    parts = spans(angle, count, overlap)
    wide = parts[0][1]
    if wide > 150.0:
        raise UserError(
            f"each of {count} projectors would light {wide:.0f} degrees of the screen, expected "
            "150 or less: more projectors, or a smaller --angle"
        )
    # Over a screen of more than half a turn a lens must stay within.
    farthest = 3.0 * radius if measures["throw"] and angle <= 180.0 else radius
    step = math.radians(parts[-1][0]) / max(count - 1, 1)  # between neighbours
    side = math.cos(step * max(count - 2, 0) / 2.0)
    if angle > 180.0:  # they stand in a ring
        ring = 0.5 * HOUSING_CM / math.sin(step / 2.0)
        farthest = 1.9 * radius if measures["throw"] else max(radius - ring, 0.3 * radius)
    channels = []
    for number, (name, (left, right)) in enumerate(zip(names_of(count), parts, strict=True)):
        table = Cylinder(
            radius_cm=radius, left_deg=_rounded(left - angle / 2.0),
            right_deg=_rounded(right - angle / 2.0), bottom_cm=bottom, top_cm=top,
        )  # fmt: skip
        screen = screens.screen_of(table, np.zeros(3), 1.0)
        assert isinstance(screen, screens.Curved)
        turn = (screen.left + screen.right) / 2.0
        ahead = np.array([math.sin(turn), 0.0, math.cos(turn)])
        raised = np.array([0.0, top + ABOVE_CM, 0.0])
        tries = []
        for far in radius - np.linspace(0.3 * radius, farthest, STEPS):
            # Lenses near the axis would stand in one another: they stand in a row there.
            gap = max(HOUSING_CM - 2.0 * abs(far) * math.sin(step / 2.0) * side, 0.0)
            aside = (number - (count - 1) / 2.0) * math.copysign(gap, far) * (angle <= 180.0)
            tries.append(far * ahead + raised + [aside, 0.0, 0.0])
        edge = screens.points_on(screen, _BORDER)
        lens = lenses.placed(
            tries, edge, _aspect(measures), measures["throw"], "its part of the screen"
        )

        def shares(place: Array, ways: Array, screen: screens.Curved = screen) -> Array:
            return screens.places_on(screen, lenses.on_cylinder(place, ways, radius))

        channels.append(PlannedChannel(name, table, lens, _mesh(lens, shares)))
    return TheatreLayout(
        f"A curved screen, projectors: {count}", channels, -measures["eye"], True,
        notes=[
            f"each picture takes {wide:.1f} degrees, {overlap * wide:.1f} of them shared with each "
            "neighbour",
            _lens_note(channels),
        ],
    )  # fmt: skip


def _cave(measures: Mapping[str, float]) -> TheatreLayout:
    """Walls, floor, ceiling and back of a room whose middle is the eye's place."""
    count, half, high = int(measures["projectors"]), measures["width"] / 2.0, measures["height"]
    if not 2 <= count <= 6:
        raise UserError(f"--projectors {count}: a cave has 2 to 6, one for each wall")
    low = -measures["eye"]
    top = low + high
    if top <= 10.0:
        raise UserError(
            f"--height {high:g}: walls end below the eyes at {measures['eye']:g} cm, expected more"
        )
    walls: dict[str, tuple[Point, Point, Point]] = {
        "front": ((-half, low, half), (half, low, half), (-half, top, half)),
        "left": ((-half, low, -half), (-half, low, half), (-half, top, -half)),
        "right": ((half, low, half), (half, low, -half), (half, top, half)),
        "floor": ((-half, low, -half), (half, low, -half), (-half, low, half)),
        "ceiling": ((-half, top, half), (half, top, half), (-half, top, -half)),
        "back": ((half, low, -half), (-half, low, -half), (half, top, -half)),
    }
    channels = []
    size = int(measures["across"]), int(measures["down"])
    for name, corners in list(walls.items())[:count]:
        first, second, third = (np.array(corner) for corner in corners)
        along, up = second - first, third - first
        inward = np.cross(up, along) / (np.linalg.norm(up) * np.linalg.norm(along))
        # Seen through from behind, but the floor is lit from above.
        behind = 1.2 * np.linalg.norm(along) * (inward if name == "floor" else -inward)
        axes = np.stack([along, up, -behind])
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        # Square pixels: a screen that is narrower than a picture, or lower, takes a part of it.
        wide, tall = float(np.linalg.norm(along)), float(np.linalg.norm(up))
        scale = max(wide / size[0], tall / size[1])  # cm of a pixel
        width, height = round(wide / scale), round(tall / scale)
        place = (size[0] - width) // 2, (size[1] - height) // 2, width, height
        far = 2.0 * float(np.linalg.norm(behind)) / scale
        lens = lenses.Lens(
            first + (along + up) / 2.0 + behind, axes, (size[0] / far, size[1] / far)
        )
        plane = Plane(lower_left=corners[0], lower_right=corners[1], upper_left=corners[2])
        viewport = None if place == (0, 0, *size) else place
        channels.append(PlannedChannel(name, plane, lens, viewport=viewport))
    title = f"A room of {count} screens"
    return TheatreLayout(title, channels, -measures["eye"], notes=[_lens_note(channels)])


def _dome(measures: Mapping[str, float]) -> TheatreLayout:
    """Rings of pictures and one around the zenith, from lenses at the far side of the rim."""
    count, radius = int(measures["projectors"]), measures["radius"]
    dome = Dome(tilt_deg=measures["tilt"], distance_cm=max(radius, 50.0))
    title = f"A dome, projectors: {count}"
    turned = axes_of(0.0, -math.radians(measures["tilt"]))  # its zenith leans to the front
    if count == 1:
        fisheye = PlannedChannel("dome", dome, lenses.Lens(np.zeros(3), turned, (1.0, 1.0)))
        return TheatreLayout(title, [fisheye], -measures["eye"], dome=dome)
    if count < 4:
        raise UserError(f"--projectors {count}: a dome has 1 (a fisheye), or 4 or more")
    overlap = measures["overlap"] / 100.0
    channels: list[PlannedChannel] = []
    for name, (heading, angles) in zip(names_of(count), _patches(count, overlap), strict=True):
        axes = axes_of(heading, math.radians(angles.pitch_deg)) @ turned
        table = _turned(angles, axes, radius)
        screen = screens.screen_of(table, np.zeros(3), 1.0)
        border = screens.points_on(screen, _BORDER)
        border *= radius / np.linalg.norm(border, axis=1, keepdims=True)
        taken = [channel.lens.place for channel in channels]

        def lens_at(turn: float, heading: float = heading, border: Array = border,
                    part: str = f"its part of the dome ({name})") -> lenses.Lens:  # fmt: skip
            way = heading + math.pi + math.radians(turn)
            back = np.array([math.sin(way), 0.0, math.cos(way)]) @ turned
            tries = [s * radius * back for s in np.linspace(0.0, RIM, STEPS)]
            return lenses.placed(tries, border, _aspect(measures), measures["throw"], part)

        lens = lens_at(0.0)
        for turn in TURNS:
            if all(np.linalg.norm(lens.place - place) >= HOUSING_CM for place in taken):
                break
            with suppress(UserError):  # where its throw ratio does not fit
                lens = lens_at(turn)
        else:
            lens = lens_at(0.0)

        def shares(place: Array, ways: Array, screen: screens.Screen = screen) -> Array:
            return screens.places_on(screen, lenses.on_sphere(place, ways, radius))

        channels.append(PlannedChannel(name, table, lens, _mesh(lens, shares)))
    return TheatreLayout(
        title, channels, -measures["eye"], True, dome, notes=[_lens_note(channels)]
    )


def _patches(count: int, overlap: float) -> list[tuple[float, Angles]]:
    """Heading, rad, and view of each projector of an upright dome, from the lowest ring up."""
    rings = 1 + sum(count >= more for more in RINGS)
    step = math.pi / 2.0 / (rings + 0.5)
    shared = overlap * step / (1.0 - overlap)
    weights = np.cos((np.arange(rings) + 0.5) * step)
    numbers = np.maximum(np.round((count - 1) * weights / weights.sum()).astype(int), 3)
    numbers[0] += count - 1 - numbers.sum()
    patches = []
    for ring, number in enumerate(numbers.tolist()):
        low = max(ring * step - shared / 2.0, 0.0)
        high = min((ring + 1) * step + shared / 2.0, math.pi / 2.0)
        half = math.pi / number / (1.0 - overlap)
        for k in range(number):
            pitch = (low + high) / 2.0
            turn, rise = np.meshgrid(np.linspace(-half, half, 181), np.linspace(low, high, 61))
            level = np.cos(rise)
            ways = np.stack([np.sin(turn) * level, np.sin(rise), np.cos(turn) * level], axis=-1)
            view = _view(ways.reshape(-1, 3) @ axes_of(0.0, pitch).T, pitch, count)
            patches.append((2.0 * math.pi * (k + 0.5 * (ring % 2)) / number, view))
    reach = math.degrees(math.pi / 2.0 - rings * step + shared / 2.0)
    zenith = Angles(left_deg=-reach, right_deg=reach, down_deg=-reach, up_deg=reach, pitch_deg=90.0)
    return [*patches, (0.0, zenith)]


def _view(seen: Array, pitch: float, count: int) -> Angles:
    """The flat view that takes in directions (n, 3) in its own axes."""
    slopes = seen[:, :2] / np.maximum(seen[:, 2:], 1e-6)
    if seen[:, 2].min() <= 0.0 or np.abs(slopes).max() > 0.9 * screens.STEEPEST:
        raise UserError(
            f"--projectors {count}: with this --overlap each would light too much of the dome, "
            "expected more projectors or less overlap"
        )
    left, down = np.degrees(np.arctan(slopes.min(axis=0)))
    right, up = np.degrees(np.arctan(slopes.max(axis=0)))
    return Angles(
        left_deg=float(left), right_deg=float(right), down_deg=float(down), up_deg=float(up),
        pitch_deg=math.degrees(pitch),
    )  # fmt: skip


def _turned(angles: Angles, axes: Array, radius: float) -> Angles:
    """The view with its edges and these axes (3, 3), as a theatre file has them."""
    heading, pitch, roll = heading_pitch_roll(axes)
    return Angles(
        left_deg=_rounded(angles.left_deg), right_deg=_rounded(angles.right_deg),
        down_deg=_rounded(angles.down_deg), up_deg=_rounded(angles.up_deg),
        heading_deg=_rounded(heading), pitch_deg=_rounded(pitch), roll_deg=_rounded(roll),
        distance_cm=radius,
    )  # fmt: skip


def _mirror(measures: Mapping[str, float]) -> TheatreLayout:
    """One projector onto a convex mirror at the rear of a dome."""
    radius, tilt = measures["radius"], measures["tilt"]
    setup = lenses.mirror_setup(
        radius, measures["mirror"], measures["throw"] or 1.5, _aspect(measures), math.radians(tilt)
    )
    dome = Dome(tilt_deg=tilt, distance_cm=max(radius, 50.0))
    channel = PlannedChannel("dome", dome, setup.lens, setup.nodes)
    x, y, z = map(_rounded, setup.centre)
    sphere = SphericalMirror(centre_cm=(x, y, z), radius_cm=measures["mirror"])
    notes = [f"the mirror lights {100 * setup.lit:.0f}% of the dome"]
    return TheatreLayout(
        "A dome with a spherical mirror", [channel], -measures["eye"], False, dome, sphere, notes
    )


def _aspect(measures: Mapping[str, float]) -> float:
    return measures["across"] / measures["down"]


def _mesh(lens: lenses.Lens, shares: Callable[[Array, Array], Array]) -> Array:
    """The mesh of a lens; a UserError if it lights next to nothing of its picture."""
    nodes = lenses.warp_nodes(lens, NODES, shares)
    used = nodes[..., 4] > 0
    lit = float((used & (np.abs(nodes[..., 2:4] - 0.5) <= 0.5).all(axis=-1)).mean())
    if lit < LEAST_LIT:
        raise UnlitError(
            f"each projector would use {100 * lit:.0f}% of its pixels, expected {LEAST_LIT:.0%} or "
            "more: another number of projectors"
        )
    return nodes


def _lens_note(channels: Sequence[PlannedChannel]) -> str:
    ratios = sorted(channel.lens.throw for channel in channels)
    least, most = f"{ratios[0]:.2f}", f"{ratios[-1]:.2f}"
    if least == most:
        return f"throw ratio of the lenses, distance over width of the picture: {least}"
    return f"throw ratios of the lenses, distance over width of the picture: {least} to {most}"


def _rounded(number: float) -> float:
    """A number as it stands in a file."""
    return round(float(number), 3) + 0.0
