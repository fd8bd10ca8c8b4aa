"""A species file while it is drawn: an immutable state, and the edits that lead to the next one.

A draft holds what the file says, as plain tables and lists, beside the species that it makes. Every
edit either makes a draft that loads or is refused with a sentence that says why: so what is saved
can always be read, and is what was shown. Places are (distance behind the snout, height or half-
width) in body lengths in both views, the scaffold's too, though its file keeps them in cm.
"""

import tomllib
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from shutil import copyfile
from typing import Any, Literal, NamedTuple

import numpy as np
from msgspec import structs

from subsea.biomechanics.body_plan import HALF_SIZES, NODES_AT_STATION, SHORTEST_SECTION
from subsea.core.atomic_io import replacing
from subsea.core.errors import UserError
from subsea.core.toml_edit import edit_toml
from subsea.core.toml_files import load_toml
from subsea.core.validation import convert
from subsea.fish.species import Species, own_species_file
from subsea.fish.surface import along

View = Literal["side", "top"]
Box = tuple[float, float, float, float]  # left, low, right, high
Path_ = tuple[str | int, ...]

CURVES = ("back", "belly", "width")
FINS = ("dorsal", "ventral")
RIDGES = {"back": "dorsal", "belly": "ventral"}  # and the fins that stand on them
PADDLES = ("pectoral", "pelvic")
SOFT = 0.12  # body lengths from a point at which its neighbours go a third of its way along
GAP = 0.004  # body lengths between two points of a curve
THIN = {"back": (0.001, 1.0), "belly": (-1.0, -0.001), "width": (0.0005, 1.0)}  # their values
FEWEST = {"back": 3, "belly": 3, "width": 3, "dorsal": 3, "ventral": 3, "tail": 2, "wing": 5}
SHAPE_DIGITS, CM_DIGITS = 4, 3
TRIES = 9  # halvings of a way that ends where no species is


class EditError(Exception):
    """An edit that would make no species; the message says why in a sentence."""


@dataclass(frozen=True, eq=False)
class Draft:
    """What a species file says now."""

    key: str  # the file's name without its suffix; "" before there is one
    content: dict[str, Any]
    species: Species
    text: str  # the file that was read or copied: comments and order are kept from it
    sheet: Path | None = None  # the picture that it wears instead of what is painted


class Spot(NamedTuple):
    """A point of a view that can be dragged."""

    path: Path_  # what of the draft it is
    at: tuple[float, float]  # behind the snout, and up or aside; body lengths
    mirror: bool = False  # whether it has a twin on the other side of the spine


def read(path: Path) -> Draft:
    """The draft of a species file; a faulty one is a UserError in one line."""
    species = load_toml(path, Species)
    text = path.read_bytes().decode("utf-8")  # with the ends of lines that it has
    sheet = path.absolute().with_name(species.skin.sheet) if species.skin.sheet else None
    return Draft(path.stem, tomllib.loads(text), species, text, sheet)


def copied(source: Draft, key: str, name: str) -> Draft:
    """A new species that is built as another one is; `key` names its file, `name` is for people."""
    try:
        own_species_file(key)
    except UserError as fault:
        raise EditError(str(fault)) from None
    if not name.strip():
        raise EditError("A species needs a name for people, such as Red snapper.")
    draft = changed(source, ("name",), name.strip())
    if source.sheet:  # each has a picture of its own
        draft = changed(draft, ("skin", "sheet"), f"{key}.png")
    return replace(draft, key=key)


def worn(draft: Draft) -> Species:
    """The species with the whole path of its picture, as those have that are loaded."""
    sheet = str(draft.sheet) if draft.sheet and draft.species.skin.sheet else None
    return structs.replace(draft.species, skin=structs.replace(draft.species.skin, sheet=sheet))


def at_path(draft: Draft, path: Path_) -> Any:
    """What the draft says there."""
    here: Any = draft.content
    for step in path:
        here = here[step]
    return here


def changed(draft: Draft, path: Path_, value: Any) -> Draft:
    """The draft with another value there; None takes the key away."""
    return _checked(draft, _replaced(draft.content, path, value))


def changed_all(draft: Draft, values: dict[Path_, Any]) -> Draft:
    """The same for several values at once."""
    content = draft.content
    for path, value in values.items():
        content = _replaced(content, path, value)
    return _checked(draft, content)


def _checked(draft: Draft, content: dict[str, Any]) -> Draft:
    try:
        species = convert(content, Species)
    except UserError as fault:
        raise EditError(str(fault)) from None
    return replace(draft, content=content, species=species)


def _replaced(here: Any, path: Path_, value: Any) -> Any:
    """A copy of tables and lists, as far as they change."""
    if not path:
        return value
    step, rest = path[0], path[1:]
    if isinstance(here, list):
        assert isinstance(step, int)
        return [_replaced(old, rest, value) if k == step else old for k, old in enumerate(here)]
    out = dict(here)
    if not rest and value is None:
        out.pop(step, None)
    else:
        out[step] = _replaced(out.get(step, {}), rest, value) if rest else value
    return out


# What can be dragged


def spots(draft: Draft, view: View) -> list[Spot]:
    """Every point of a view that can be dragged, the scaffold's first."""
    surface, found = draft.content["surface"], _ring_spots(draft, view)
    if view == "top":
        found += [
            Spot(("surface", "width", k), tuple(p), True) for k, p in enumerate(surface["width"])
        ]
        if wing := surface.get("wing"):
            found += [
                Spot(("surface", "wing", "outline", k), tuple(p), True)
                for k, p in enumerate(wing["outline"])
            ]
        return found
    for name in CURVES[:2]:
        found += [Spot(("surface", name, k), tuple(p)) for k, p in enumerate(surface[name])]
    for name in FINS:
        if fin := surface.get(name):
            ridge = draft.content["surface"]["back" if name == "dorsal" else "belly"]
            for k, x in enumerate(fin["base"]):
                y = float(along(ridge, np.array([x]))[0])
                found.append(Spot(("surface", name, "base", k), (x, y)))
            found += [
                Spot(("surface", name, "edge", k), tuple(p)) for k, p in enumerate(fin["edge"])
            ]
    tail = surface["tail"]
    found.append(Spot(("surface", "tail", "begin"), (tail["begin"], 0.0)))
    middle, radius = _tail_heights(draft)
    for k, (share, x) in enumerate(tail["edge"]):
        found.append(Spot(("surface", "tail", "edge", k), (x, middle + share * radius)))
    for name in PADDLES:
        if fin := surface.get(name):
            root = fin["at"], fin["height"]
            droop = np.radians(fin["droop"])
            tip = root[0] + fin["length"] * np.cos(droop), root[1] - fin["length"] * np.sin(droop)
            found.append(Spot(("surface", name, "at"), root))
            found.append(Spot(("surface", name, "length"), (float(tip[0]), float(tip[1]))))
    eye = surface["eye"]
    if not surface.get("wing"):
        found.append(Spot(("surface", "eye"), (eye["at"], eye["height"])))
    return found


def _ring_spots(draft: Draft, view: View) -> list[Spot]:
    body = draft.content.get("body")
    if not body:
        return []
    length = body["stations"][-1]
    sizes = body["half_heights"] if view == "side" else body["half_widths"]
    found = [
        Spot(("body", "ring", k), (x / length, size / length), True)
        for k, (x, size) in enumerate(zip(body["stations"][1:6], sizes, strict=True))
    ]
    if view == "side":
        found.append(Spot(("body", "ring", 5), (1.0, body["tail_half_height"] / length), True))
    return found


def _tail_heights(draft: Draft) -> tuple[float, float]:
    """Middle and half the height of the tail's edge, body lengths."""
    surface = draft.species.surface
    edge = surface.tail.edge_at(np.array([-1.0, 1.0]))
    top, bottom = (
        float(along(curve, np.array([x]))[0])
        for curve, x in ((surface.back, edge[1]), (surface.belly, edge[0]))
    )
    return (top + bottom) / 2, max((top - bottom) / 2, 1e-6)


def moved(
    draft: Draft, view: View, path: Path_, to: tuple[float, float], soft: bool = False
) -> Draft:
    """A point of a view dragged to a place, or as far toward it as makes a species.

    It keeps between its neighbours. The draft itself is returned where it cannot move at all. Where
    it is `soft` the points about it on the back, the belly or the width go along, the less the
    farther off they are.
    """
    after = _moved(draft, view, path, to)
    name, k = path[1], path[-1]
    if soft and name in CURVES and isinstance(k, int):
        curve, ridge = at_path(draft, path[:-1]), [*at_path(after, path[:-1])]
        rise = ridge[k][1] - curve[k][1]
        for j, (x, y) in enumerate(curve):
            if j != k:
                share = np.exp(-(((x - curve[k][0]) / SOFT) ** 2))
                ridge[j] = [x, _short(float(np.clip(y + share * rise, *THIN[name])))]
        with suppress(EditError):
            return changed_all(draft, {path[:-1]: ridge} | _carried(draft, str(name), ridge))
    return after


def _moved(draft: Draft, view: View, path: Path_, to: tuple[float, float]) -> Draft:
    """The point alone."""
    start = next(spot.at for spot in spots(draft, view) if spot.path == path)
    if path[:2] != ("surface", "eye") and any(
        s.mirror for s in spots(draft, view) if s.path == path
    ):
        to = to[0], abs(to[1])
    if to == start:
        return draft
    trial = _trial(draft, view, path)
    for aim in (to, (to[0], start[1]), (start[0], to[1])):
        with suppress(EditError):
            there = trial(*aim)
            if there.content != draft.content:
                return there
    low, high, best = 0.0, 1.0, draft
    for _ in range(TRIES):
        share = 0.5 * (low + high)
        try:
            best = trial(*(a + share * (b - a) for a, b in zip(start, to, strict=True)))
            low = share
        except EditError:
            high = share
    return best


def _trial(draft: Draft, view: View, path: Path_) -> Callable[[float, float], Draft]:
    """What takes a place and gives the draft with the point there, or an EditError."""
    surface = draft.content["surface"]

    def shape(x: float, y: float) -> Draft:
        curve = at_path(draft, path[:-1])
        k = path[-1]
        assert isinstance(k, int)
        name = str(path[1])
        if name in CURVES:
            x = _between(curve, k, x)
            y = float(np.clip(y, *THIN[name]))
        else:
            x, y = float(np.clip(x, 0.0, 1.0)), float(np.clip(y, -1.0, 1.0))
        if name == "wing":
            y = max(y, 0.0)
        point = [_short(x), _short(y)]
        if name not in RIDGES:
            return changed(draft, path, point)
        ridge = [point if number == k else old for number, old in enumerate(curve)]
        return changed_all(draft, {path[:-1]: ridge} | _carried(draft, name, ridge))

    def base(x: float, y: float) -> Draft:
        return changed(draft, path, _short(float(np.clip(x, 0.0, 1.0))))

    def tail_edge(x: float, y: float) -> Draft:
        edge, k = surface["tail"]["edge"], path[-1]
        assert isinstance(k, int)
        middle, radius = _tail_heights(draft)
        share = (y - middle) / radius
        if k in (0, len(edge) - 1):
            share = edge[k][0]
        else:
            share = float(np.clip(share, edge[k - 1][0] + 0.02, edge[k + 1][0] - 0.02))
        return changed(draft, path, [_short(share), _short(float(np.clip(x, 0.0, 1.0)))])

    def root(x: float, y: float) -> Draft:
        paddle = path[:2]
        return changed_all(draft, {(*paddle, "at"): _share(x), (*paddle, "height"): _extent(y)})

    def tip(x: float, y: float) -> Draft:
        paddle = path[:2]
        plan = at_path(draft, paddle)
        dx, dy = x - plan["at"], plan["height"] - y
        droop = float(np.degrees(np.arctan2(dy, max(dx, 1e-6))))
        length = _share(max(float(np.hypot(dx, dy)), 0.01))
        return changed_all(
            draft,
            {(*paddle, "length"): length, (*paddle, "droop"): round(np.clip(droop, -90, 90), 1)},
        )

    def eye(x: float, y: float) -> Draft:
        return changed_all(
            draft, {("surface", "eye", "at"): _share(x), ("surface", "eye", "height"): _extent(y)}
        )

    def ring(x: float, y: float) -> Draft:
        return _with_ring(draft, view, int(path[2]), x, y)

    if path[0] == "body":
        return ring
    if path[1] == "eye":
        return eye
    if path[1:] == ("tail", "begin") or path[2] == "base":
        return base
    if path[1] == "tail":
        return tail_edge
    if path[2] == "at":
        return root
    return tip if path[2] == "length" else shape


def _carried(draft: Draft, name: str, ridge: list[Any]) -> dict[Path_, Any]:
    """The free edge of the fin that stands on a ridge, which goes along with it."""
    fin = draft.content["surface"].get(RIDGES.get(name, ""))
    if not fin:
        return {}
    edge = np.array(fin["edge"], float)
    if np.any(np.diff([p[0] for p in ridge]) <= 0):
        return {}
    edge[:, 1] += along(ridge, edge[:, 0]) - along(draft.content["surface"][name], edge[:, 0])
    return {("surface", RIDGES[name], "edge"): [[_short(x), _extent(y)] for x, y in edge]}


def _with_ring(draft: Draft, view: View, k: int, x: float, y: float) -> Draft:
    """Ring `k`, or the tail's tips (5), at a place and as tall or wide as that."""
    body = draft.content["body"]
    length = body["stations"][-1]
    size = round(float(np.clip(y, *HALF_SIZES)) * length, CM_DIGITS)
    if k == 5:
        return changed(draft, ("body", "tail_half_height"), size)
    room = SHORTEST_SECTION * length
    front, rear = body["stations"][k] + room, body["stations"][k + 2] - room
    station = round(float(np.clip(x * length, min(front, rear), rear)), CM_DIGITS)
    sizes = "half_heights" if view == "side" else "half_widths"
    return changed_all(draft, {("body", "stations", k + 1): station, ("body", sizes, k): size})


def _between(curve: Sequence[Sequence[float]], k: int, x: float) -> float:
    """`x` between the points before and behind number `k` of a curve."""
    low = curve[k - 1][0] + GAP if k else 0.0
    high = curve[k + 1][0] - GAP if k + 1 < len(curve) else 1.0
    return curve[k][0] if low > high else float(np.clip(x, low, high))


# Points more and fewer


def added(draft: Draft, view: View, at: tuple[float, float]) -> tuple[Draft, Path_]:
    """A further point on the line of the view that runs nearest to a place, and what it is.

    EditError where two points of that line are too close already. In the top view both sides are
    one.
    """
    at = (at[0], abs(at[1])) if view == "top" else at
    path = nearest_line(draft, view, at)[0]
    _, k, place = _distance(dict(_lines(draft, view))[path], at)
    name = path[1]
    curve = list(at_path(draft, path))
    if name in CURVES:
        x = _short(float(np.clip(at[0], 0.0, 1.0)))
        k = int(np.searchsorted([p[0] for p in curve], x)) - 1
        y = _short(float(along(curve, np.array([x]))[0]))
        point, around = [x, y], [abs(p[0] - x) for p in curve]
    elif name == "tail":
        middle, radius = _tail_heights(draft)
        share = _short(float((place[1] - middle) / radius))
        if curve[0][0] == 0.0:
            share = abs(share)
        shares = [p[0] for p in curve]
        k = int(np.searchsorted(shares, share)) - 1
        x = float(draft.species.surface.tail.edge_at(np.array([share]))[0])
        point, around = [share, _short(x)], [abs(s - share) for s in shares]
    else:
        point = [_short(float(place[0])), _short(float(place[1]))]
        around = [float(np.hypot(p[0] - point[0], p[1] - point[1])) for p in curve]
    if min(around) < GAP:
        raise EditError("There is a point already: drag it, or add one farther from it.")
    curve.insert(k + 1, point)
    return changed(draft, path, curve), (*path, k + 1)


def nearest_line(draft: Draft, view: View, at: tuple[float, float]) -> tuple[Path_, float]:
    """The line of a view that runs nearest to a place, and how far off it is, body lengths."""
    at = (at[0], abs(at[1])) if view == "top" else at
    found = [(path, _distance(points, at)[0]) for path, points in _lines(draft, view)]
    return min(found, key=lambda pair: pair[1])


def removed(draft: Draft, path: Path_) -> Draft:
    """The draft without a point of a line; EditError where the line needs it, or it is none."""
    name = str(path[1])
    if path[0] != "surface" or not isinstance(path[-1], int) or path[2] == "base":
        raise EditError("Only points of outlines can be taken away: a scaffold has five rings.")
    curve = at_path(draft, path[:-1])
    if len(curve) <= FEWEST[name]:
        raise EditError(f"This line needs {FEWEST[name]} points at least.")
    return changed(draft, path[:-1], [p for k, p in enumerate(curve) if k != path[-1]])


def _lines(draft: Draft, view: View) -> list[tuple[Path_, list[tuple[float, float]]]]:
    """The lines of a view that take further points, in its places."""
    groups: dict[Path_, list[tuple[float, float]]] = {}
    for spot in spots(draft, view):
        if spot.path[0] == "surface" and isinstance(spot.path[-1], int) and spot.path[2] != "base":
            groups.setdefault(spot.path[:-1], []).append(spot.at)
    return list(groups.items())


def _distance(
    points: Sequence[tuple[float, float]], at: tuple[float, float]
) -> tuple[float, int, tuple[float, float]]:
    """How far a place is from a line, which of its pieces is nearest, and the place on that."""
    best = (np.inf, 0, points[0])
    p = np.asarray(at)
    for k, (a, b) in enumerate(pairwise(points)):
        start, way = np.asarray(a), np.subtract(b, a)
        t = float(np.clip((p - start) @ way / max(way @ way, 1e-12), 0.0, 1.0))
        foot = start + t * way
        far = float(np.linalg.norm(p - foot))
        if far < best[0]:
            best = (far, k, (float(foot[0]), float(foot[1])))
    return best


# Larger edits


def with_fin(draft: Draft, name: str, there: bool) -> Draft:
    """The draft with a fin, or without it; a new one is plain, and has the flank's colour."""
    surface, skin = draft.content["surface"], draft.content["skin"]
    if not there:
        return changed(draft, ("surface", name), None)
    if surface.get(name):
        return draft
    values: dict[Path_, Any] = {}
    if name in FINS:
        ridge, sign = (surface["back"], 1.0) if name == "dorsal" else (surface["belly"], -1.0)
        x = np.array([0.35, 0.4, 0.5, 0.6, 0.65]) if sign > 0 else np.linspace(0.55, 0.72, 5)
        tall = np.array([0.0, 0.06, 0.07, 0.05, 0.0]) - 0.005
        edge = np.clip(along(ridge, x) + sign * tall, -1.0, 1.0)
        values["surface", name] = {
            "base": [_short(float(x[0])), _short(float(x[-1]))],
            "edge": [[_short(float(a)), _short(float(b))] for a, b in zip(x, edge, strict=True)],
        }
        colours = name
    else:
        at, height = (0.28, 0.25) if name == "pectoral" else (0.36, 0.75)
        level = float(along(surface["belly"], np.array([at]))[0])
        values["surface", name] = {
            "at": at, "height": _extent(height * level), "length": 0.12, "width": 0.07,
            "droop": 15.0 if name == "pectoral" else 35.0,
        }  # fmt: skip
        colours = "paddles"
    if colours not in skin:
        values["skin", colours] = {"colour": list(skin["flank"])}
    return changed_all(draft, values)


def as_heavy(draft: Draft, grams: float) -> Draft:
    """All masses in proportion, so that the body weighs so much."""
    masses = draft.content["body"]["masses"]
    now = sum(m * n for m, n in zip(masses, NODES_AT_STATION, strict=True))
    return changed(draft, ("body", "masses"), [float(f"{m * grams / now:.3g}") for m in masses])


def as_long(draft: Draft, cm: float) -> Draft:
    """The scaffold at another length of the model, in proportion; its masses grow as its volume."""
    body = draft.content["body"]
    times = cm / body["stations"][-1]
    scaled: dict[Path_, Any] = {
        ("body", key): [round(times * x, CM_DIGITS) for x in body[key]]
        for key in ("stations", "half_widths", "half_heights")
    }
    scaled["body", "tail_half_height"] = round(times * body["tail_half_height"], CM_DIGITS)
    scaled["body", "masses"] = [float(f"{times**3 * m:.3g}") for m in body["masses"]]
    return changed_all(draft, scaled)


# Files


def to_toml(draft: Draft) -> str:
    """The file: as it was read, but for the values that are others now."""
    return edit_toml(draft.text, tomllib.loads(draft.text), draft.content)


def differs(path: Path, known: Draft | None) -> bool:
    """Whether a file is there that says something else than the one that is known, if any."""
    try:
        return path.read_bytes() != (known.text.encode("utf-8") if known else None)
    except OSError:
        return False  # nothing is there that could be lost, or saving tells what is wrong


def save(draft: Draft, path: Path) -> None:
    """Write the species file, whole or not at all; UserError where it cannot be.

    The picture that a copy wears is copied with it; one that is there already is left alone.
    """
    text = to_toml(draft)
    if draft.sheet and (name := draft.species.skin.sheet):
        own = path.with_name(name)
        if not own.exists():
            with replacing(own) as temporary:
                copyfile(draft.sheet, temporary)
    with replacing(path) as temporary:
        temporary.write_bytes(text.encode("utf-8"))
        if load_toml(temporary, Species) != draft.species:
            raise UserError("its tables cannot be edited", file=path)


def _short(x: float) -> float:
    return round(float(x), SHAPE_DIGITS)


def _share(x: float) -> float:
    return _short(float(np.clip(x, 0.0, 1.0)))


def _extent(x: float) -> float:
    return _short(float(np.clip(x, -1.0, 1.0)))
