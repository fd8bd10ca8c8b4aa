"""Placement (Tu §9.1): pick the things of a scenario with the pointer, move and edit them.

No function changes a world: each returns another scenario. A ray is an eye (3,), cm, and a unit
vector (3,).

Outlines of things are lines (n, 2, 3) to draw, cm.
"""

import math
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import msgspec
import numpy as np
from msgspec.structs import replace

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.geometry.periodic import gathered
from subsea.geometry.solids import (
    NEVER,
    height_at,
    ray_meets_pillar,
    ray_meets_rock,
    ray_meets_seabed,
)
from subsea.geometry.vector import vector
from subsea.habitat.sea import solids_on
from subsea.scenario.directions import renumbered
from subsea.scenario.schema import (
    Arch,
    CoralTable,
    Hook,
    Outcrop,
    Pillar,
    ReefTable,
    Ridge,
    Rock,
    Scenario,
    SeaweedTable,
    Shoal,
    Vent,
    Wreck,
)
from subsea.scenario.shoals import with_shoal_size
from subsea.state import HULL_CM, Fishes, Sea

SIDES = 32  # segments of a circle


def circle(middle: tuple[float, float, float], radius: float) -> Array:
    """Make the lines (SIDES, 2, 3) of a horizontal circle."""
    turn = np.linspace(0.0, 2.0 * np.pi, SIDES + 1)
    flat = np.stack([np.cos(turn), np.sin(turn), np.zeros(SIDES + 1)], axis=1)
    points = np.array(middle) + radius * flat
    return np.stack([points[:-1], points[1:]], axis=1)


def ellipses(rows: Array) -> Array:
    """Make the lines (3 k SIDES, 2, 3) of the principal ellipses of k ellipsoids."""
    turn = np.linspace(0.0, 2.0 * np.pi, SIDES + 1)
    c, s, o = np.cos(turn), np.sin(turn), np.zeros(SIDES + 1)
    unit = np.stack([np.stack(axes, axis=1) for axes in ((c, s, o), (c, o, s), (o, c, s))])
    out = []
    for x, y, z, *half, yaw in rows:
        across = np.array([[np.cos(yaw), np.sin(yaw), 0.0], [-np.sin(yaw), np.cos(yaw), 0.0],
                           [0.0, 0.0, 1.0]])  # fmt: skip
        points = (unit * half) @ across + (x, y, z)
        out.append(np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3))
    return np.concatenate(out) if out else np.zeros((0, 2, 3))


Place = tuple[float, float, float]  # x, y, z in cm

KINDS = {
    "fish": "a school", "pillar": "a pillar", "rock": "a rock", "outcrop": "a knoll",
    "ridge": "a ridge", "arch": "an arch", "wreck": "a wreck", "seaweed": "seaweed",
    "reef": "a reef", "coral": "a single coral", "vent": "a vent of bubbles",
    "hook": "the hook", "submarine": "where the submarine starts",
}  # fmt: skip
"""Tables of a scenario with a place, and their display names."""

FREE = ("fish", "hook", "submarine")  # suspended in the water; all others stand on the seabed
SINGLE = ("hook", "submarine")  # at most one of these
KNOB_CM = 18.0  # radius of the handle of things without a body
GROUPS_ABOVE_CM = 25.0  # height of the handles of plants over the seabed
AHEAD_CM = 420.0  # greatest distance of a new thing
NEW_ABOVE_CM = 90.0  # height over the seabed of a new thing that is suspended


class Handle(NamedTuple):
    """Handle of a thing with a place: ``scenario.KIND[number]``."""

    kind: str  # one of `KINDS`
    number: int  # in the scenario's list, 0 for the hook and the submarine
    place: Place  # its foot on the seabed, or its middle in the water
    body: Array  # for rays: (k, 7) ellipsoids as `Sea.rocks`, or (1, 4) as `Sea.pillars`
    outline: Array  # (n, 2, 3) lines to draw, cm


class Grip(NamedTuple):
    """A handle that is being dragged."""

    handle: Handle
    offset: Array  # (3,) from the direction of the pointer to that of its place
    facing: Array  # (3,) horizontal unit vector from the eye, normal of the plane of motion


def handles(scenario: Scenario, sea: Sea) -> list[Handle]:
    """Make handles of all things with a place, on the seabed of `sea`."""
    _, rows, names = solids_on(scenario, sea.heights, sea.half_width)
    out = [
        _handle("submarine", 0, scenario.submarine.position_cm, HULL_CM, sea),
        *_each("fish", scenario.fish, sea, lambda shoal: shoal.spread_cm),
        *_each("seaweed", scenario.seaweed, sea, lambda group: group.spread_cm),
        *_each("reef", scenario.reef, sea, lambda reef: reef.spread_cm),
        *_each("coral", scenario.coral, sea, lambda coral: coral.size_cm),
        *_each("vent", scenario.vent, sea, lambda vent: KNOB_CM),
    ]
    if scenario.hook is not None:
        out.append(_handle("hook", 0, scenario.hook.bait_cm, KNOB_CM, sea))
    for kind in ("rock", "outcrop", "ridge", "arch", "wreck"):
        for k, table in enumerate(getattr(scenario, kind)):
            body = rows[[name == f"`{kind}[{k}]`" for name in names]]
            out.append(Handle(kind, k, _foot(table, sea), body, ellipses(body)))
    for k, pillar in enumerate(scenario.pillar):
        x, y, z = foot = _foot(pillar, sea)
        top = z + pillar.height_cm
        rings = [circle((x, y, height), pillar.radius_cm) for height in (z, top)]
        posts = np.stack([ring[:: SIDES // 4, 0] for ring in rings], axis=1)
        body = np.array([[x, y, pillar.radius_cm, top]])
        out.append(Handle("pillar", k, foot, body, np.concatenate([*rings, posts])))
    return out


def schools(now: Scenario, trial: Scenario, fishes: Fishes, sea: Sea) -> list[Handle]:
    """Make a handle of each school of the scenario `now`, in the middle of its living fishes.

    If the scenario `trial` moves a school, its handle is there. A school without a place in `trial`
    or without living fishes has no handle.
    """
    out, begin = [], 0
    for k, shoal in enumerate(now.fish):
        members = slice(begin, begin + shoal.number)
        begin += shoal.number
        given = trial.fish[k].position_cm if k < len(trial.fish) else None
        if given is None or not fishes.alive[members].any():
            continue
        x, y, z = given
        if given == shoal.position_cm:
            living = fishes.position[members][fishes.alive[members]]
            x, y, z = gathered(living, fishes.period).mean(axis=0).tolist()
        out.append(_handle("fish", k, (x, y, z), trial.fish[k].spread_cm, sea))
    return out


def pick(candidates: list[Handle], sea: Sea, eye: Array, direction: Array) -> Handle | None:
    """Find the first handle that a ray meets before the seabed."""
    a, b = _ray(sea, eye, direction)
    least = ray_meets_seabed(sea.heights, sea.half_width, 0.0, a, b)
    nearest = None
    for handle in candidates:
        meets = ray_meets_pillar if handle.body.shape[1] == 4 else ray_meets_rock
        for row in handle.body:
            t = meets(row, 0.0, a, b)
            if t < least:
                least, nearest = t, handle
    return nearest


def grip(handle: Handle, eye: Array, direction: Array) -> Grip:
    """Begin to drag a handle."""
    toward = np.array(handle.place) - eye
    facing = toward * (1.0, 1.0, 0.0)
    size = np.linalg.norm(facing)
    facing = facing / size if size > 1e-6 else np.array([1.0, 0.0, 0.0])
    return Grip(handle, toward / max(float(np.linalg.norm(toward)), 1e-6) - direction, facing)


def aim(held: Grip, sea: Sea, eye: Array, direction: Array, level: bool = False) -> Place | None:
    """Find the place of a dragged handle for a ray of the pointer; None outside the sea.

    Things on the seabed move along it. Suspended things move vertically and sideways; with
    `level` horizontally at their depth.
    """
    direction = direction + held.offset
    direction = direction / max(float(np.linalg.norm(direction)), 1e-9)
    if held.handle.kind not in FREE:
        a, b = _ray(sea, eye, direction)
        t = ray_meets_seabed(sea.heights, sea.half_width, 0.0, a, b)
        if t == NEVER:
            return None
    else:
        facing = np.array([0.0, 0.0, 1.0]) if level else held.facing
        along = float(direction @ facing)
        t = float((np.array(held.handle.place) - eye) @ facing) / along if along else -1.0
        if t <= 0.0:
            return None
        a, b = vector(eye), vector(eye + direction)
    x, y, z = (a[axis] + t * (b[axis] - a[axis]) for axis in range(3))
    if held.handle.kind in FREE:
        z = min(max(z, _floor(sea, x, y)), 0.0)
    return (x, y, z) if math.hypot(x, y) < sea.radius else None


def moved(scenario: Scenario, handle: Handle, place: Place) -> Scenario:
    """Move a thing, to the centimetre."""
    x, y, z = (float(round(value)) for value in place)
    if handle.kind == "hook":
        return _with(scenario, handle, position_cm=(x, y), depth_cm=_clamped(Hook, "depth_cm", -z))
    return _with(scenario, handle, position_cm=(x, y, z) if handle.kind in FREE else (x, y))


SIZES = {
    "fish": ("spread_cm",), "seaweed": ("spread_cm",), "reef": ("spread_cm",), "vent": ("size_cm",),
    "pillar": ("radius_cm", "height_cm"), "rock": ("size_cm",), "outcrop": ("size_cm",),
    "ridge": ("length_cm", "width_cm", "height_cm"), "coral": ("size_cm",),
    "arch": ("span_cm", "height_cm", "thickness_cm"),
    "wreck": ("length_cm", "width_cm", "height_cm", "mast_cm"),
}  # fmt: skip
"""Keys of each kind that scale with its size."""

TURNS = dict.fromkeys(("fish", "submarine"), "heading_deg") | dict.fromkeys(
    ("rock", "outcrop", "ridge", "arch", "wreck", "coral"), "yaw_deg"
)
"""Key of each kind for its direction."""


def resized(scenario: Scenario, handle: Handle, factor: float) -> Scenario:
    """Scale a thing within its limits."""
    table = table_of(scenario, handle.kind, handle.number)
    changes: dict[str, Any] = {}
    for key in SIZES.get(handle.kind, ()):
        value = getattr(table, key)
        if isinstance(value, tuple):
            changes[key] = tuple(_clamped(type(table), key, factor * part) for part in value)
        else:
            changes[key] = _clamped(type(table), key, factor * value)
    return _with(scenario, handle, **changes)


def turned(scenario: Scenario, handle: Handle, degrees: float) -> Scenario:
    """Turn a thing left, if its kind has a direction."""
    key = TURNS.get(handle.kind)
    if key is None:
        return scenario
    angle = float(
        round((getattr(table_of(scenario, handle.kind, handle.number), key) or 0.0) + degrees)
    )
    return _with(scenario, handle, **{key: (angle + 180.0) % 360.0 - 180.0})


def raised(scenario: Scenario, handle: Handle, factor: float) -> Scenario:
    """Scale the height of a thing on the seabed within its limits."""
    table = table_of(scenario, handle.kind, handle.number)
    if handle.kind in ("pillar", "ridge", "arch", "wreck", "seaweed"):
        high = _clamped(type(table), "height_cm", factor * table.height_cm)
        return _with(scenario, handle, height_cm=high)
    if handle.kind in ("rock", "outcrop"):
        wide, deep, high = table.size_cm
        high = _clamped(type(table), "size_cm", factor * high)
        return _with(scenario, handle, size_cm=(wide, deep, high))
    return scenario


def place_ahead(sea: Sea, eye: Array, direction: Array) -> Place:
    """Place on the seabed along a ray, at most `AHEAD_CM` away, inside the sea."""
    a, b = _ray(sea, eye, direction)
    t = ray_meets_seabed(sea.heights, sea.half_width, 0.0, a, b)
    far = float(np.linalg.norm(np.subtract(b, a))) * t if t < NEVER else np.inf
    unit = np.asarray(direction) / np.linalg.norm(direction)
    x, y, _ = np.asarray(eye) + min(far, AHEAD_CM) * unit
    inward = min(1.0, 0.95 * sea.radius / max(math.hypot(x, y), 1e-6))
    x, y = inward * float(x), inward * float(y)
    return x, y, _floor(sea, x, y)


def added(scenario: Scenario, kind: str, place: Place, sea: Sea) -> Scenario:
    """Add a thing of a kind at a place, at the end of its list."""
    x, y, z = (float(round(value)) for value in place)
    # Suspended things are put above the seabed.
    high = max(z, min(round(_floor(sea, x, y) + NEW_ABOVE_CM), -NEW_ABOVE_CM))
    on, number = (x, y), 0 if kind in SINGLE else len(getattr(scenario, kind))
    new: dict[str, msgspec.Struct] = {
        "fish": Shoal(
            species=scenario.fish[-1].species, number=8, position_cm=(x, y, high), spread_cm=80.0
        ),
        "pillar": Pillar(position_cm=on, radius_cm=25.0, height_cm=150.0),
        "rock": Rock(position_cm=on, size_cm=(45.0, 35.0, 30.0)),
        "outcrop": Outcrop(position_cm=on, size_cm=(120.0, 90.0, 80.0), seed=number),
        "ridge": Ridge(position_cm=on, length_cm=240.0, width_cm=90.0, height_cm=90.0, seed=number),
        "arch": Arch(position_cm=on, span_cm=350.0, height_cm=250.0, seed=number),
        "wreck": Wreck(position_cm=on, length_cm=900.0, width_cm=280.0, seed=number),
        "seaweed": SeaweedTable(position_cm=on, spread_cm=60.0, clusters=4),
        "reef": ReefTable(position_cm=on, spread_cm=120.0, number=40, seed=number),
        "coral": CoralTable(kind="staghorn", position_cm=on, seed=number),
        "vent": Vent(position_cm=on),
        "hook": Hook(position_cm=on, depth_cm=-high),
    }
    if kind == "submarine":
        start = replace(scenario.submarine, position_cm=(x, y, high))
        return replace(scenario, submarine=start)
    if kind == "hook":
        return replace(scenario, hook=new[kind])
    return replace(scenario, **{kind: [*getattr(scenario, kind), new[kind]]})


def removed(scenario: Scenario, handle: Handle) -> Scenario:
    """Remove a thing; raises a UserError for the submarine and the last school."""
    if handle.kind == "submarine" or (handle.kind == "fish" and len(scenario.fish) == 1):
        raise UserError(f"{KINDS[handle.kind]} cannot be taken away: a dive needs it")
    if handle.kind == "hook":
        return replace(scenario, hook=None)
    if handle.kind == "fish":
        scenario = with_shoal_size(scenario, handle.number, 0)
        gone = handle.number
        directions = renumbered(
            scenario.direction, lambda fish: fish, lambda k: -1 if k == gone else k - (k > gone)
        )
        scenario = replace(scenario, direction=directions)
    tables = list(getattr(scenario, handle.kind))
    del tables[handle.number]
    return replace(scenario, **{handle.kind: tables})


def table_of(scenario: Scenario, kind: str, number: int) -> Any:
    """Return the table of a thing, or None if there is no such thing."""
    tables = getattr(scenario, kind)
    if kind in SINGLE:
        return tables
    return tables[number] if number < len(tables) else None


def with_table(scenario: Scenario, kind: str, number: int, table: msgspec.Struct) -> Scenario:
    """Replace the table of a thing."""
    if kind in SINGLE:
        return replace(scenario, **{kind: table})
    if isinstance(table, Shoal):
        scenario = with_shoal_size(scenario, number, table.number)
    tables = list(getattr(scenario, kind))
    tables[number] = table
    return replace(scenario, **{kind: tables})


def _with(scenario: Scenario, handle: Handle, **changes: Any) -> Scenario:
    """Change keys of a thing."""
    table = replace(table_of(scenario, handle.kind, handle.number), **changes)
    return with_table(scenario, handle.kind, handle.number, table)


def _clamped(table: type[msgspec.Struct], key: str, value: float) -> float:
    """Clamp a length to the limits of its key, and round a large length to the centimetre."""
    value = float(round(value)) if value >= 20.0 else round(value, 1)
    for limit in _limits(get_type_hints(table, include_extras=True)[key]):
        least = value if limit.ge is None else limit.ge
        value = max(value, 0.1 if 0.0 < least < 0.1 else least)
        value = min(value, limit.le if limit.le is not None else value)
    return float(value)


def _limits(kind: Any) -> list[msgspec.Meta]:
    """List all limits in a type annotation."""
    outer = [part for part in getattr(kind, "__metadata__", ()) if isinstance(part, msgspec.Meta)]
    inner = get_args(kind)[:1] if get_origin(kind) in (Annotated, tuple) else ()
    return outer + [limit for part in inner for limit in _limits(part)]


def _floor(sea: Sea, x: float, y: float) -> float:
    return float(height_at(sea.heights, sea.half_width, x, y))


def _foot(table: Any, sea: Sea) -> Place:
    x, y = table.position_cm
    return x, y, _floor(sea, x, y)


def _ray(sea: Sea, eye: Array, direction: Array) -> tuple[Any, Any]:
    """Compute both ends of a ray through the whole sea."""
    return vector(eye), vector(np.asarray(eye) + 2.5 * sea.half_width * np.asarray(direction))


def _each(kind: str, tables: Any, sea: Sea, reach: Any) -> list[Handle]:
    """Make handles of the tables of a list that have a place."""
    out = []
    for k, table in enumerate(tables):
        if table.position_cm is not None:
            place = table.position_cm if kind in FREE else _foot(table, sea)
            out.append(_handle(kind, k, place, reach(table), sea))
    return out


def _handle(kind: str, index: int, place: Place, reach: float, sea: Sea) -> Handle:
    """Make a handle: a small ellipsoid, and a circle as wide as the thing on the seabed."""
    x, y, z = place
    middle = place if kind in FREE else (x, y, z + GROUPS_ABOVE_CM)
    knob = np.array([[*middle, KNOB_CM, KNOB_CM, KNOB_CM, 0.0]])
    ring = circle(place, reach)
    if kind not in FREE:
        for corner in ring.reshape(-1, 3):
            corner[2] = _floor(sea, corner[0], corner[1]) + 2.0
    line = [[place, middle]] if kind not in FREE else [[(x, y, 0.0), place]] * (kind == "hook")
    lines = np.array(line, np.float64).reshape(-1, 2, 3)
    return Handle(kind, index, place, knob, np.concatenate([ring, ellipses(knob), lines]))
