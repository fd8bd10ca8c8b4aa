"""Diagrams of invisible things: springs of bodies, senses, bonds of schools (Tu §9.2, §9.4).

The drawing modes of Tu's general control, and a few more: lines in the world, and labels. Diagrams
of fishes are drawn for those in sight, the largest in the picture first and at most MOST of them;
that of the chosen fish is stronger than others.
"""

from collections import deque
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.base.errors import unknown
from subsea.biomechanics.body import KINDS, UNITS
from subsea.fish.surface import DORSAL, FIN_U, FIN_V, LEFT, RIGHT, VENTRAL, U, V
from subsea.geometry.rotation import matrix
from subsea.geometry.solids import height_at
from subsea.motor.pose import pose_at
from subsea.perception.collision import ANTENNA_BL, caution, sensitivity
from subsea.perception.vision import FIELD_COS
from subsea.repertoire import SEGMENTS
from subsea.state import NOBODY
from subsea.view.camera import View
from subsea.view.culling import IN_SIGHT, coverage, view_arrays
from subsea.view.display_rigs import cockpit, views_for
from subsea.view.retina import (
    FishEyes,
    bodies_at,
    control_points_at,
    fish_eyes,
    retina_rig,
    retinal_views,
)
from subsea.view.rig import CameraRig, Projection
from subsea.world.world import World

ROUND = 48  # pieces of a circle


class Lines(NamedTuple):
    """k straight lines in the world."""

    ends: Array  # (k, 2, 3) float32, cm
    colours: Array  # (k, 4) float32: sRGB as on the screen; opacity
    # (k,) float32, cm by which the depth test moves a line toward the eye, so that lines within a
    # body show.
    lift: Array


NO_LINES = Lines(
    np.zeros((0, 2, 3), np.float32), np.zeros((0, 4), np.float32), np.zeros(0, np.float32)
)


def join_lines(parts: Iterable[Lines]) -> Lines:
    """The lines of all parts."""
    return Lines(*(np.concatenate(column) for column in zip(NO_LINES, *parts, strict=True)))


def make_lines(ends: Any, colours: Any, lift: Any = 0.0) -> Lines:
    """Opaque lines of one colour or of (…, 3) colours."""
    placed = np.asarray(ends, np.float32).reshape(-1, 2, 3)
    tinted = np.ones((len(placed), 4), np.float32)
    tinted[:, :3] = np.asarray(colours, np.float32).reshape(-1, 3)
    lifted = np.broadcast_to(np.asarray(lift, np.float32), len(placed))
    return Lines(placed, tinted, lifted)


def faded(parts: Iterable[Lines], opacity: float) -> list[Lines]:
    """Parts with their opacity multiplied."""
    share = np.array([1.0, 1.0, 1.0, opacity], np.float32)
    return [part._replace(colours=part.colours * share) for part in parts]


def arc(middle: Array, radius: float, a: Array, b: Array, low: float, high: float) -> Array:
    """An arc of lines (ROUND, 2, 3) from `low` to `high` rad, from unit vector a toward b."""
    turn = np.linspace(low, high, ROUND + 1)[:, None]
    points = middle + radius * (np.cos(turn) * a + np.sin(turn) * b)
    return np.stack([points[:-1], points[1:]], axis=1)


def frustum_edges(view: View, reach_cm: float) -> Array:
    """Edges (8, 2, 3), cm, of a frustum: four from the eye, four around its end at `reach_cm`."""
    inverse = np.linalg.inv(view.projection.astype(np.float64) @ view.view.astype(np.float64))
    corners = np.array([(-1, -1, 1, 1), (1, -1, 1, 1), (1, 1, 1, 1), (-1, 1, 1, 1)]) @ inverse.T
    rays = corners[:, :3] / corners[:, 3:] - view.eye
    ahead = -view.view[2, :3].astype(np.float64)
    ends = view.eye + reach_cm * rays / (rays @ ahead)[:, None]
    edges = [(view.eye, end) for end in ends]
    return np.array(edges + [(ends[k - 1], ends[k]) for k in range(4)])


class Label(NamedTuple):
    """Text at a point in the world."""

    place: Array  # (3,) cm
    text: str


class PlacedLabel(NamedTuple):
    """A label in a finished picture."""

    output: int
    x: float  # pixels from the left and from the top, of the middle of its lower edge
    y: float
    text: str


def place_labels(
    rig: CameraRig, views: Sequence[View], labels: Sequence[Label]
) -> list[PlacedLabel]:
    """Place labels on the flat patches of a rig that draws these `views`, the farthest first."""
    found = []
    for patch in rig.patches:
        view = next((one for one in views if one.viewport == patch.left), None)
        if view is None or patch.shape != Projection.FLAT:
            continue
        x, y, width, height = patch.place
        top = rig.outputs[patch.output][1]
        for distance, across, up, text in projected(view, labels):
            at = PlacedLabel(patch.output, x + width * across, top - y - height * up, text)
            found.append((distance, at))
    return [at for _, at in sorted(found, key=lambda pair: -pair[0])]


def projected(view: View, labels: Sequence[Label]) -> list[tuple[float, float, float, str]]:
    """Distance in cm, x and y in shares of the viewport from its lower left, and text of labels."""
    if not labels:
        return []
    places = np.array([label.place for label in labels])
    both = view.projection.astype(np.float64) @ view.view.astype(np.float64)
    clip = np.concatenate([places, np.ones((len(places), 1))], axis=1) @ both.T
    inside = (clip[:, 3] > 0.0) & (np.abs(clip[:, :2]) <= clip[:, 3:]).all(axis=1)
    shares = 0.5 + 0.5 * clip[:, :2] / np.where(inside, clip[:, 3], 1.0)[:, None]
    return [
        (float(clip[k, 3]), float(shares[k, 0]), float(shares[k, 1]), labels[k].text)
        for k in np.flatnonzero(inside).tolist()
    ]


Colour = tuple[float, float, float]  # sRGB as on the screen, 0 to 1

DIAGRAMS = {
    "scaffold": "springs and muscles of bodies, the redder the more they contract",
    "control mesh": "control points that the skin is drawn from",
    "sensitivity": "the box that nobody may enter, and the ray that feels for obstacles",
    "school": "whom a schooling fish follows, and its companions",
    "perception": "how far a fish sees and smells, and where it is blind",
    "frusta": "what the submarine and the chosen fish's eyes look at",
    "axes": "axes of the world and of bodies: ahead red, up green, right blue",
    "paths": "where fishes and the submarine were in the last seconds",
    "bounds": "the edge of the sea",
    "indices": "numbers of fishes",
}
"""Names of the diagrams, with descriptions."""

# The most fishes that have each diagram.
MOST = {
    "scaffold": 60, "control mesh": 24, "sensitivity": 60, "school": 400, "perception": 3,
    "axes": 100, "paths": 200, "indices": 100,
}  # fmt: skip

AROUND = ("sensitivity", "school", "perception")  # diagrams outside of a body

# Colours that differ in meaning remain apart for colour-blind eyes: see `test_colours.py`.
PALE, RED = (0.95, 0.86, 0.80), (0.95, 0.10, 0.08)  # a muscle at rest, and contracted
CONTRACTED = 0.2  # shortening, as a share of the length, at which a muscle is all red
CROSS, OTHER = (0.45, 0.62, 0.72), (0.86, 0.92, 0.94)
MESH, FIN = (0.98, 0.92, 0.50), (0.85, 0.45, 0.15)
CALM, ALARMED = (0.36, 0.90, 0.66), (0.95, 0.30, 0.20)
LEADER, COMPANION = (0.95, 0.80, 0.30), (0.45, 0.80, 0.95)
SIGHT, SMELL, BLIND = (0.45, 0.70, 1.0), (0.98, 0.95, 0.55), (0.80, 0.22, 0.25)
VESSEL, EYES = (0.98, 0.80, 0.35), (0.70, 0.92, 1.0)
AXES: tuple[Colour, ...] = (0.90, 0.20, 0.15), (0.75, 0.95, 0.45), (0.25, 0.40, 0.95)
PATH, WAKE, EDGE = (0.90, 0.90, 0.75), (0.95, 0.90, 0.72), (0.80, 0.90, 0.95)

STRONG, PLAIN, FAINT = 1.0, 0.75, 0.35  # opacity: of the chosen fish, of all, of others
ABOVE_CM = 3.0  # height of a number above the back
EACH_TICKS, KEPT = 3, 50  # of paths: ticks between points, and their number
FRUSTUM_CM, RETINA_CM = 160.0, 25.0  # length of frusta
WIDE = 256, 144  # picture whose aspect the submarine's frustum has
AXIS_BL, AXIS_CM = 0.6, 100.0  # length of a body's axes and of the world's
BOX_EDGES = np.array([(a, a | bit) for a in range(8) for bit in (1, 2, 4) if not a & bit])


class Diagram(NamedTuple):
    """Lines and labels."""

    lines: Lines
    labels: tuple[Label, ...] = ()


def chosen_diagrams(text: str) -> tuple[str, ...]:
    """The diagrams of a list such as "scaffold,frusta"; raises UserError for unknown names."""
    names = [name.strip().replace("_", " ").replace("-", " ") for name in text.split(",")]
    for name in filter(None, names):
        if name not in DIAGRAMS:
            raise unknown("diagram", name, list(DIAGRAMS))
    return tuple(name for name in DIAGRAMS if name in names)


class DiagramBuilder:
    """Builds the diagrams of a world; remembers past positions for paths."""

    def __init__(self, world: World) -> None:
        self.world = world
        self._trail: deque[tuple[int, Array]] = deque(maxlen=KEPT)
        self._riders: dict[int, FishEyes] = {}
        slow = SEGMENTS.index("swim_slow")
        first, count = world.library.first[:, slow], world.library.length[:, slow]
        self._rest = np.array(  # of units (s, 91), means over a recorded beat
            [
                _lengths(world.library.nodes[row : row + rows]).mean(axis=0)
                for row, rows in zip(first, count, strict=True)
            ]
        )

    def follow(self) -> None:
        """Remember positions for `paths`, and drop those after the current tick."""
        tick, state = self.world.state.tick, self.world.state
        while self._trail and self._trail[-1][0] > tick:
            self._trail.pop()
        if not self._trail or tick - self._trail[-1][0] >= EACH_TICKS:
            places = [state.fishes.position, state.submarine.position[None]]
            self._trail.append((tick, np.concatenate(places).astype(np.float32)))

    def draw(
        self, shown: Collection[str], views: Sequence[View], alpha: float, chosen: int | None = None
    ) -> Diagram:
        """Build the diagrams named in `shown`, `alpha` of the way from the last tick to this one.

        `chosen` is the fish that a visitor has picked or rides.
        """
        if "paths" in shown:
            self.follow()
        if not shown:
            return Diagram(NO_LINES)
        of_fishes: dict[str, Callable[[Ints, float], Iterable[Lines]]] = {
            "scaffold": self._scaffold,
            "control mesh": self._control_mesh,
            "sensitivity": self._sensitivity,
            "school": self._school,
            "perception": self._perception,
            "axes": self._axes,
            "paths": self._paths,
        }
        alive = self.world.state.fishes.alive
        seen = self._in_sight(views, alpha, chosen)
        parts: list[Lines] = []
        for name, draw in of_fishes.items():
            if name not in shown:
                continue
            most = seen[: MOST[name]]
            if chosen is None:
                parts += faded(draw(most, alpha), PLAIN)
                continue
            # A ridden fish sees diagrams around it, but none in its body.
            there = alive[chosen] and (name in AROUND or chosen in most)
            parts += faded(draw(np.array([chosen] * there, np.int64), alpha), STRONG)
            if name != "perception":
                parts += faded(draw(most[most != chosen], alpha), FAINT)
        if "frusta" in shown:
            parts += faded(self._frusta(views, alpha, chosen), PLAIN)
        if "axes" in shown:
            parts.append(self._world_axes())
        if "paths" in shown:
            parts += faded([self._wake(alpha)], FAINT)
        if "bounds" in shown:
            parts += faded(self._bounds(), PLAIN)
        labels: tuple[Label, ...] = ()
        if "indices" in shown:
            labels = self._indices(seen[: MOST["indices"]], alpha, chosen)
        return Diagram(join_lines(parts), labels)

    def _in_sight(self, views: Sequence[View], alpha: float, chosen: int | None) -> Ints:
        """The fishes in sight of any view: the chosen one, then the largest in the picture."""
        fishes, library = self.world.state.fishes, self.world.library
        middle = fishes.previous_position + np.float32(alpha) * (
            fishes.position - fishes.previous_position
        )
        radii = library.bounding_radius[fishes.species] * fishes.length
        reach = IN_SIGHT * self.world.scenario.water.visibility_cm
        pixels, _ = coverage(middle, radii, fishes.length, view_arrays(views), reach)
        without = {view.without for view in views}
        if len(without) == 1:  # a fish does not see its own body
            pixels[[one for one in without if one >= 0]] = -1.0
        pixels[~fishes.alive] = -1.0
        if chosen is not None and pixels[chosen] >= 0.0:
            pixels[chosen] = np.inf
        order = np.argsort(-pixels, kind="stable")
        return order[: int((pixels >= 0.0).sum())]

    def _frames(self, who: Ints, alpha: float) -> tuple[Array, Array]:
        """Origins (n, 3), cm, and axes (n, 3, 3), columns, of bodies, interpolated."""
        place, turn = bodies_at(self.world, who, alpha)
        return place, matrix(turn)

    def _within(self, who: Ints, each: int) -> Array:
        """The lift of `each` lines within each of the bodies `who`."""
        fishes = self.world.state.fishes
        return np.repeat(fishes.girth[who].sum(axis=1), each)

    def _scaffold(self, who: Ints, alpha: float) -> Iterable[Lines]:
        """The 91 springs between the nodes of each fish."""
        fishes, library = self.world.state.fishes, self.world.library
        nodes = np.zeros((len(who), *library.nodes.shape[1:]))
        for k, i in enumerate(who):
            a, b, weight = pose_at(fishes, library, i, alpha)
            nodes[k] = (1.0 - weight) * library.nodes[a] + weight * library.nodes[b]
        shorter = 1.0 - _lengths(nodes) / self._rest[fishes.species[who]]
        share = np.clip(shorter / CONTRACTED, 0.0, 1.0)[..., None]
        colours = np.array([PALE, CROSS, OTHER])[KINDS] * np.ones((len(who), 1, 1))
        muscles = KINDS == 0
        colours[:, muscles] += share[:, muscles] * (np.array(RED) - PALE)
        place, axes = self._frames(who, alpha)
        body = fishes.scale[who][:, None, None] * nodes
        world = place[:, None] + np.einsum("nij,nkj->nki", axes, body)
        yield make_lines(world[:, UNITS], colours, self._within(who, len(UNITS)))

    def _control_mesh(self, who: Ints, alpha: float) -> Iterable[Lines]:
        """The grids of control points of both body halves and of the two median fins."""
        place, axes = self._frames(who, alpha)
        for k, i in enumerate(who):
            points = control_points_at(self.world, int(i), alpha)
            world = place[k] + self.world.state.fishes.scale[i] * points @ axes[k].T
            ends, colours = world[GRID_EDGES], np.where(ON_BODY[:, None], MESH, FIN)
            yield make_lines(ends, colours, self._within(who[k : k + 1], len(ends)))

    def _sensitivity(self, who: Ints, alpha: float) -> Iterable[Lines]:
        """The box and ray of `perception.collision`, red while they are not free; the threat."""
        minds, fishes = self.world.state.minds, self.world.state.fishes
        place, axes = self._frames(who, alpha)
        for k, i in enumerate(who):
            low, high = sensitivity_box(self.world, int(i))
            corner = np.array([[c & 1, c >> 1 & 1, c >> 2 & 1] for c in range(8)])
            box = place[k] + (low + corner * (high - low)) @ axes[k].T
            threat = int(minds.threat[i])
            yield make_lines(box[BOX_EDGES], CALM if threat == NOBODY else ALARMED)
            reach = caution(minds, int(i), self.world.nature) * ANTENNA_BL * float(fishes.length[i])
            snout = place[k] + float(fishes.snout[i]) * axes[k][:, 0]
            tip = snout + reach * axes[k][:, 0]
            yield make_lines([(snout, tip)], CALM if minds.barrier[i] == -1 else ALARMED)
            if threat != NOBODY:
                there, _ = self._frames(np.array([threat]), alpha)
                yield make_lines([(snout, there[0])], ALARMED)

    def _school(self, who: Ints, alpha: float) -> Iterable[Lines]:
        """Lines from each schooling fish to its neighbours, and to a leader that it follows."""
        minds, alive = self.world.state.minds, self.world.state.fishes.alive
        schooling = who[minds.schools[who]]
        led = schooling[minds.led[schooling] & (minds.leader[schooling] >= 0)]
        led = led[alive[minds.leader[led]]]
        near = minds.neighbour[schooling]
        pairs = np.stack([np.repeat(schooling, near.shape[1]), near.ravel()], axis=1)
        pairs = np.unique(np.sort(pairs[pairs[:, 1] >= 0], axis=1), axis=0)
        pairs = pairs[alive[pairs].all(axis=1)]
        for those, colour in (
            (pairs, COMPANION),
            (np.stack([led, minds.leader[led]], axis=1), LEADER),
        ):
            ends, _ = self._frames(those.ravel(), alpha)
            yield make_lines(ends.reshape(-1, 2, 3), colour)

    def _perception(self, who: Ints, alpha: float) -> Iterable[Lines]:
        """Range of vision for standard sizes (Tu §6.3), blind cone, and range of smell."""
        nature = self.world.nature
        bodies = self.world.state.fishes
        place, axes = self._frames(who, alpha)
        edge = np.arccos(FIELD_COS)
        for k, i in enumerate(who):
            ahead, up, right = axes[k].T
            eye = place[k] + float(bodies.snout[i]) * ahead
            for aside in (up, right):
                yield make_lines(arc(eye, nature.vision_cm, ahead, aside, -edge, edge), SIGHT)
            for one, other in ((ahead, up), (ahead, right), (up, right)):
                yield make_lines(arc(eye, nature.smell_cm, one, other, -np.pi, np.pi), SMELL)
            behind = eye + FIELD_COS * nature.vision_cm * ahead
            rim = arc(behind, np.sin(edge) * nature.vision_cm, up, right, -np.pi, np.pi)
            yield make_lines(rim, BLIND)
            yield make_lines([(eye, rim[n, 0]) for n in range(0, ROUND, ROUND // 8)], BLIND)

    def _frusta(self, views: Sequence[View], alpha: float, chosen: int | None) -> Iterable[Lines]:
        """Frusta of the submarine and of the chosen fish, unless the view is from there."""
        pilot = views_for("mono", WIDE, cockpit(self.world.state.submarine, alpha))
        shown = [(view, FRUSTUM_CM, VESSEL) for view in pilot]
        if chosen is not None and self.world.state.fishes.alive[chosen]:
            if chosen not in self._riders:
                self._riders = {chosen: fish_eyes(self.world, chosen)}
            by = self._riders[chosen]
            rig = retina_rig((64, 48), by.half_cm)
            shown += [(view, RETINA_CM, EYES) for view in retinal_views(self.world, by, rig, alpha)]
        for view, reach, colour in shown:
            if all(np.linalg.norm(np.asarray(view.eye) - one.eye) > 10.0 for one in views):
                yield make_lines(frustum_edges(view, reach), colour)

    def _axes(self, who: Ints, alpha: float) -> Iterable[Lines]:
        """Body axes: forward, up, right."""
        place, axes = self._frames(who, alpha)
        length = AXIS_BL * self.world.state.fishes.length[who][:, None]
        for axis, colour in enumerate(AXES):
            tip = place + length * axes[:, :, axis]
            yield make_lines(np.stack([place, tip], axis=1), colour, self._within(who, 1))

    def _world_axes(self) -> Lines:
        """World axes over the middle of the seabed: x red, y green, z blue."""
        sea = self.world.state.sea
        foot = np.array([0.0, 0.0, height_at(sea.heights, sea.half_width, 0.0, 0.0) + 2.0])
        tips = foot + AXIS_CM * np.eye(3)
        return join_lines(
            make_lines([(foot, tip)], colour) for tip, colour in zip(tips, AXES, strict=True)
        )

    def _paths(self, who: Ints, alpha: float) -> Iterable[Lines]:
        place, _ = self._frames(who, alpha)
        yield self._way(who, place, PATH)

    def _wake(self, alpha: float) -> Lines:
        submarine = self.world.state.submarine
        before = submarine.previous_position
        now = before + alpha * (submarine.position - before)
        return self._way(np.array([-1]), now[None], WAKE)

    def _way(self, columns: Ints, now: Array, colour: Colour) -> Lines:
        """Lines through the remembered positions of some columns to the current ones."""
        tick = self.world.state.tick
        past = [places[columns] for at, places in self._trail if at < tick]
        points = np.stack([*past, now], axis=1)
        return make_lines(
            np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3), colour
        )

    def _bounds(self) -> Iterable[Lines]:
        """The cylinder that bounds the sea, from the seabed to the surface."""
        sea = self.world.state.sea
        middle, x, y = np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
        above = arc(middle, sea.radius, x, y, -np.pi, np.pi)
        below = above.copy()
        for point in below.reshape(-1, 3):
            point[2] = height_at(sea.heights, sea.half_width, point[0], point[1]) + 2.0
        yield make_lines(np.concatenate([above, below]), EDGE)
        yield make_lines(np.stack([below[::4, 0], above[::4, 0]], axis=1), EDGE)

    def _indices(self, who: Ints, alpha: float, chosen: int | None) -> tuple[Label, ...]:
        """The number of each fish above its back; for the chosen one the species too."""
        fishes = self.world.state.fishes
        place, _ = self._frames(who, alpha)
        place[:, 2] += 0.5 * fishes.girth[who, 0] + ABOVE_CM
        name = "" if chosen is None else self.world.species[fishes.species[chosen]].name
        texts = [f"{name} {i}" if i == chosen else f"{i}" for i in who]
        return tuple(Label(*pair) for pair in zip(place, texts, strict=True))


def sensitivity_box(world: World, i: int) -> tuple[Array, Array]:
    """Lowest and highest corner (3,) of fish i's sensitivity region, cm, in body axes.

    `perception.collision.share_inside` enlarges it by half the size of the other fish.
    """
    fishes = world.state.fishes
    length, snout = float(fishes.length[i]), float(fishes.snout[i])
    room = sensitivity(world.state.minds, i, world.nature)[0] * length
    tall, wide = 0.5 * fishes.girth[i].astype(np.float64) + room
    return np.array([snout - length - room, -tall, -wide]), np.array([snout + room, tall, wide])


def _grid(first: int, rows: int, columns: int) -> list[tuple[int, int]]:
    """Pairs of neighbours in a grid of control points."""
    number = first + np.arange(rows * columns).reshape(rows, columns)
    along = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
    across = np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1)
    return [(int(a), int(b)) for a, b in np.concatenate([along, across])]


_BODY = [*_grid(LEFT.start, U, V), *_grid(RIGHT.start, U, V)]
_FINS = [*_grid(DORSAL.start, FIN_U, FIN_V), *_grid(VENTRAL.start, FIN_U, FIN_V)]
GRID_EDGES = np.array(_BODY + _FINS)
"""Pairs (m, 2) of adjacent control points: two grids of 9 × 21, two of 2 × 12."""
ON_BODY = np.arange(len(GRID_EDGES)) < len(_BODY)


def _lengths(nodes: Array) -> Array:
    """Lengths (…, 91) of the springs, cm, between nodes (…, 23, 3)."""
    ends = nodes[..., UNITS, :]
    return np.asarray(np.linalg.norm(ends[..., 1, :] - ends[..., 0, :], axis=-1))
