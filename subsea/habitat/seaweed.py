"""Seaweed: leaves as chains of masses and springs, moved by the water (Tu §8.2)."""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.base.disk_cache import cached
from subsea.geometry.angles import sine
from subsea.geometry.solids import height_at
from subsea.geometry.vector import ZERO, Vector, minus, norm, plus, times, vector
from subsea.habitat.contact import clearance
from subsea.habitat.current import bow_wave, flow_near
from subsea.habitat.formations import formations, stone_above
from subsea.habitat.reef import MOUND, RUBBLE
from subsea.habitat.rocks import RockCells
from subsea.habitat.sea import bare
from subsea.kernels import kernel
from subsea.kernels.lanes import LANES, as_lanes, where_positive, zero_of
from subsea.scenario.schema import Scenario
from subsea.scenario.schema import SeaweedTable as Group
from subsea.state import HULL_CM, Clock, Fishes, Reef, Sea, Seaweed

KINDS = ("ribbon", "kelp", "grass", "red")  # as `seaweed.vert`
NODES = 8
SUBSTEPS = 4
# Per mass of the root node; springs and viscosity are the same for all nodes.
SPRING = 1600.0  # 1/s²
DAMPING = 5.0  # 1/s, along a spring
VISCOSITY = 9.0  # 1/s: μ_w
BUOYANCY_CM_S2 = 120.0
MASS = np.linspace(1.0, 0.3, NODES)  # from the root to the tip
SPACING = np.linspace(1.3, 0.7, NODES - 1)  # distances of nodes over their mean

EDDY_CM_S = 1.6  # eddies: speed, period and wavelength
EDDY_S, EDDY_CM = 3.7, 130.0
BODY_BL = 0.28  # radius of a fish for the leaves, over its length
SHOVE_CM_S = 90.0  # speed of the water that a body displaces
TORRENT_CM_S = 80.0  # fastest water that leaves feel
TOUCHING = 10  # most fishes that push a cluster at a time
MARGIN_CM = 40.0  # range of a fish's middle around a cluster that it pushes
CELL_CM = 100.0
SETTLING = 240  # ticks in still water before the first

WIDTH = 0.075  # of a broad leaf, over its length
WIDTH_CM = {"kelp": 8.0, "grass": 2.6, "red": 2.4}  # of a blade
COLOURS = {  # linear RGB
    "ribbon": (0.125, 0.130, 0.032), "kelp": (0.105, 0.090, 0.026), "grass": (0.085, 0.125, 0.035),
    "red": (0.155, 0.035, 0.042),
}  # fmt: skip
TUFT_CM = 9.0  # how far the roots of a cluster stand apart
LEAN = 1.0  # how far leaves bend out of their cluster, at the root
BURIED_CM = 4.0  # depth of the root node
ROOM_CM = 30.0  # free water under the surface
BESIDE_CM = 30.0  # height difference at which a growth is not in the way
TRIES = 30


def plant_seaweed(scenario: Scenario, sea: Sea, reef: Reef, seed: int) -> tuple[Sea, Seaweed]:
    """All seaweed of a scenario at rest in still water, and the sea with its boxes."""
    boxes, seaweed = cached(_planted, scenario.seaweed, bare(sea), reef, seed)
    return sea._replace(seaweed=boxes), seaweed


def _planted(groups: list[Group], sea: Sea, reef: Reef, seed: int) -> tuple[Array, Seaweed]:
    """The seaweed of these groups in a sea, and the boxes of its clusters."""
    first: list[int] = [0]
    rows: list[list[float]] = []
    chance, normal = [np.zeros((0, 3))], [np.zeros((0, 4))]
    seen: dict[str, int] = {}
    stones = formations(sea.pillars, sea.rocks)
    reef = reef.taken((reef.kind != MOUND) & (reef.kind != RUBBLE))
    for group in groups:
        # Groups are counted by kind, and each cluster has random numbers of its own, so that what
        # is added or moved leaves the others as they are.
        number = seen[group.kind] = seen.get(group.kind, -1) + 1
        for cluster in range(group.clusters):
            rng = np.random.default_rng([seed, KINDS.index(group.kind), number, cluster, 0x5EA])
            x, y = _middle(group.position_cm, group.spread_cm, sea, stones, reef, rng)
            vigour = rng.uniform(0.7, 1.1)
            for k in range(group.leaves):
                # Leaves of a cluster lean outward.
                outward = 2 * np.pi * (k + rng.uniform(-0.3, 0.3)) / group.leaves
                away = TUFT_CM * rng.uniform(0.2, 1.0)
                here = (x + away * float(np.cos(outward)), y + away * float(np.sin(outward)))
                ground = _ground(sea, stones, *here)
                height = group.height_cm * vigour * rng.uniform(0.6, 1.0)
                height = min(height, max(-ROOM_CM - ground, 5.0))
                width = group.width_cm or WIDTH_CM.get(group.kind, WIDTH * height)
                colour = np.array(group.colour or COLOURS[group.kind]) * rng.uniform(0.75, 1.25)
                width *= rng.uniform(0.8, 1.2)
                kind = KINDS.index(group.kind)
                rows.append([*here, ground - BURIED_CM, outward, height, width, *colour, kind])
            first.append(len(rows))
            chance.append(rng.uniform(size=(group.leaves, 3)))
            normal.append(rng.normal(size=(group.leaves, 4)))
    one, two, own = np.concatenate(chance).T
    aside, curl, turn, twist = np.concatenate(normal).T
    table = np.array(rows).reshape(-1, 10)
    n = len(table)
    facing, length = table[:, 3], table[:, 4]
    along = np.linspace(0.0, 1.0, NODES)
    bent = (facing + 0.5 * aside)[:, None] + 1.2 * curl[:, None] * along
    way = np.stack([np.cos(bent), np.sin(bent), np.zeros((n, NODES))], axis=2)
    share = (1.0 - along) + 0.35 * np.sin(2 * np.pi * (along + one[:, None]))
    lean = (LEAN * (0.3 + 0.7 * two)[:, None] * share)[:, :, None] * way
    lean[..., 2] += 1.0
    lean /= np.linalg.norm(lean, axis=2, keepdims=True)
    rest = SPACING * length[:, None] / (NODES - 1)
    node = np.zeros((n, NODES, 3))
    node[:, 0] = table[:, :3]
    node[:, 1:] = node[:, :1] + np.cumsum(rest[:, :, None] * lean[:, 1:], axis=1)
    facing = facing + 0.5 * np.pi + 0.4 * turn
    look = np.column_stack([table[:, 5], facing, 1.3 * twist, own, table[:, 6:9], length])
    starts = np.array(first, np.int32)
    cell_first, cell_cluster = _cells(node, starts, sea)
    f = np.float32
    seaweed = Seaweed(
        first=starts, rest=rest.astype(f), lean=lean.astype(f), look=look.astype(f),
        kind=table[:, 9].astype(np.uint8), cell_cm=CELL_CM, cell_first=cell_first,
        cell_cluster=cell_cluster,
        node=node.astype(f), previous=node.astype(f), velocity=np.zeros((n, NODES, 3), f),
    )  # fmt: skip
    sea = sea._replace(seaweed=np.zeros((len(starts) - 1, 6), f))
    _settle(seaweed, sea)
    seaweed.previous[:] = seaweed.node
    return sea.seaweed, seaweed


def _middle(
    middle: tuple[float, float] | None,
    spread: float,
    sea: Sea,
    stones: list[Array],
    reef: Reef,
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Find the place of a cluster: in the sea, under water, and beside other growths."""
    x, y = middle or (0.0, 0.0)
    for _ in range(TRIES):
        if middle is None:
            angle, away = rng.uniform(0, 2 * np.pi), 0.9 * sea.radius * rng.uniform() ** 0.5
            x, y = float(away * np.cos(angle)), float(away * np.sin(angle))
        else:
            x, y = (float(m + spread * rng.normal(0, 0.5)) for m in middle)
        ground = _ground(sea, stones, x, y)
        away = np.hypot(reef.place[:, 0] - x, reef.place[:, 1] - y)
        level = np.abs(reef.place[:, 2] - ground) < reef.radius + BESIDE_CM
        beside = not (level & (away < reef.radius + 0.5 * TUFT_CM)).any()
        if beside and ground < -2.0 * ROOM_CM and np.hypot(x, y) < 0.97 * sea.radius:
            break
    return x, y


def _ground(sea: Sea, stones: list[Array], x: float, y: float) -> float:
    """Height of the seabed at (x, y), or of the stone on it, cm."""
    z = height_at(sea.heights, sea.half_width, x, y)
    if clearance(sea.pillars, sea.rocks, (x, y, z)) > 0.0:
        return z
    for blocks in stones:
        z = max(z, stone_above(blocks, x, y, z))
    return z


def _cells(node: Array, first: Ints, sea: Sea) -> tuple[Ints, Ints]:
    """List, for each square cell over the sea, the clusters that a fish in it may touch."""
    side = int(2 * sea.radius / CELL_CM) + 1
    lists: list[list[int]] = [[] for _ in range(side * side)]
    for k in range(len(first) - 1):
        leaves = node[first[k] : first[k + 1]]
        # The tip of a bent leaf stays within its length of the root.
        reach = MARGIN_CM + 0.7 * float((leaves[:, -1, 2] - leaves[:, 0, 2]).max())
        low = ((leaves[:, 0, :2].min(axis=0) - reach + sea.radius) / CELL_CM).astype(int)
        high = ((leaves[:, 0, :2].max(axis=0) + reach + sea.radius) / CELL_CM).astype(int)
        for i in range(max(low[1], 0), min(high[1] + 1, side)):
            for j in range(max(low[0], 0), min(high[0] + 1, side)):
                lists[i * side + j].append(k)
    starts = np.cumsum([0] + [len(one) for one in lists]).astype(np.int32)
    return starts, np.array([k for one in lists for k in one], np.int32)


@kernel
def step_seaweed(
    who: Ints, seaweed: Seaweed, fishes: Fishes, sea: Sea, cells: RockCells, flow: Array,
    visibility: float, clock: Clock,
) -> None:  # fmt: skip
    """Move the clusters `who` by one tick in the water of current, passing fishes and submarine.

    Clusters beyond the visibility of the submarine stand still. Also writes `sea.seaweed`.
    """
    if len(who) == 0:
        return
    count, near = _passers(seaweed, fishes, sea)
    hull, velocity = vector(sea.submarine[:3]), vector(sea.submarine[3:6])
    uniform = vector(flow)
    stream, response = _still_stream(EDDY_CM_S), _response(clock.dt)
    leaves, waiting = np.empty(LANES, np.int64), 0
    moved = np.empty(len(who), np.bool_)
    for number in range(len(who)):
        k = who[number]
        # A copy of arrays would take seconds to compile.
        for leaf in range(seaweed.first[k], seaweed.first[k + 1]):
            for i in range(NODES):
                for axis in range(3):
                    seaweed.previous[leaf, i, axis] = seaweed.node[leaf, i, axis]
        box = sea.seaweed[k]
        middle = times(0.5, plus(vector(box[:3]), vector(box[3:])))
        away = norm(minus(middle, hull))
        moved[number] = away <= visibility
        if away > visibility:
            continue
        size = 0.5 * norm(minus(vector(box[3:]), vector(box[:3])))
        by_hull = away < size + 4.0 * HULL_CM
        here = flow_near(sea.pillars, cells, uniform, middle)
        for leaf in range(seaweed.first[k], seaweed.first[k + 1]):
            phase = 6.2832 * (clock.tick * clock.dt / EDDY_S + seaweed.look[leaf, 3])
            stream.phase[0, waiting] = phase
            for axis in range(3):
                stream.flow[axis, waiting] = here[axis]
            for i in range(1, NODES):
                push, p = ZERO, vector(seaweed.node[leaf, i])
                for slot in range(count[k]):
                    j = near[k, slot]
                    radius = BODY_BL * float(fishes.length[j])
                    push = plus(push, _wake(minus(p, vector(fishes.position[j])),
                                            vector(fishes.velocity[j]), radius))  # fmt: skip
                if by_hull:
                    push = plus(push, _wake(minus(p, hull), velocity, HULL_CM))
                for axis in range(3):
                    stream.push[i, axis, waiting] = push[axis]
            leaves[waiting] = leaf
            waiting += 1
            if waiting == LANES:
                _swing_leaves(seaweed, leaves, stream, response, clock.dt)
                waiting = 0
    if waiting > 0:
        _swing_leaves(seaweed, leaves[:waiting], stream, response, clock.dt)
    for number in range(len(who)):
        if moved[number]:
            _enclose(seaweed, sea, who[number])


@kernel
def _wake(place: Vector, velocity: Vector, radius: float) -> Vector:
    """Velocity of the water at `place` from the middle of a moving body."""
    wave = bow_wave(place, velocity, radius)
    away = norm(place)
    if away < radius and away > 1e-6:
        wave = plus(wave, times(SHOVE_CM_S * (1.0 - away / radius) / away, place))
    return wave


@kernel
def _passers(seaweed: Seaweed, fishes: Fishes, sea: Sea) -> tuple[Ints, Ints]:
    """Number (c,) and indices (c, TOUCHING) of the living fishes near each cluster."""
    clusters = len(seaweed.first) - 1
    side = int(np.sqrt(len(seaweed.cell_first) - 1) + 0.5)
    count = np.zeros(clusters, np.int32)
    near = np.empty((clusters, TOUCHING), np.int32)
    for i in range(len(fishes.position)):
        if not fishes.alive[i]:
            continue
        column = int((fishes.position[i, 0] + sea.radius) / seaweed.cell_cm)
        row = int((fishes.position[i, 1] + sea.radius) / seaweed.cell_cm)
        if column < 0 or row < 0 or column >= side or row >= side:
            continue
        cell = row * side + column
        for k in range(seaweed.cell_first[cell], seaweed.cell_first[cell + 1]):
            cluster = seaweed.cell_cluster[k]
            box = sea.seaweed[cluster]
            inside = count[cluster] < TOUCHING
            for axis in range(3):
                place = fishes.position[i, axis]
                inside = inside and box[axis] - MARGIN_CM < place < box[axis + 3] + MARGIN_CM
            if inside:
                near[cluster, count[cluster]] = i
                count[cluster] += 1
    return count, near


@kernel
def _settle(seaweed: Seaweed, sea: Sea) -> None:
    """Let all leaves come to rest in still water."""
    still, response = _still_stream(0.0), _response(0.033)
    everyone = np.arange(len(seaweed.node))
    for leaf in range(0, len(everyone), LANES):
        for _ in range(SETTLING):
            _swing_leaves(seaweed, everyone[leaf : leaf + LANES], still, response, 0.033)
    for k in range(len(seaweed.first) - 1):
        _enclose(seaweed, sea, k)


@kernel
def _response(dt: float) -> Array:
    """Change of each node's velocity (m, 2) in a substep by a force, and what drag leaves of it."""
    h, response = dt / SUBSTEPS, np.empty((NODES, 2))
    for i in range(NODES):
        response[i, 0] = h / MASS[i]
        response[i, 1] = 1.0 / (1.0 + response[i, 0] * VISCOSITY)
    return response


class Stream(NamedTuple):
    """The water around at most LANES leaves, each in its lane."""

    flow: Array  # (3, LANES), cm/s, at their cluster
    push: Array  # (m, 3, LANES), cm/s, that bodies add to it at each node
    phase: Array  # (1, LANES), rad, of the eddies
    eddy_cm_s: float


@kernel
def _still_stream(eddy_cm_s: float) -> Stream:
    """Water that stands still but for eddies of this speed."""
    return Stream(
        np.zeros((3, LANES)), np.zeros((NODES, 3, LANES)), np.zeros((1, LANES)), eddy_cm_s
    )


@kernel
def _swing_leaves(
    seaweed: Seaweed, leaves: Ints, stream: Stream, response: Array, dt: float
) -> None:
    """Move at most LANES `leaves` by `dt`, each in its lane of the `stream`."""
    node, velocity = np.empty((NODES, 3, LANES)), np.empty((NODES, 3, LANES))
    lean, rest = np.empty((NODES, 3, LANES)), np.empty((NODES, LANES))
    for lane in range(LANES):
        leaf = leaves[min(lane, len(leaves) - 1)]  # free lanes repeat the last leaf
        for i in range(NODES):
            for axis in range(3):
                node[i, axis, lane] = seaweed.node[leaf, i, axis]
                velocity[i, axis, lane] = seaweed.velocity[leaf, i, axis]
                lean[i, axis, lane] = seaweed.lean[leaf, i, axis]
            if i > 0:
                rest[i, lane] = seaweed.rest[leaf, i - 1]
    water = np.empty((NODES, 3, LANES))
    _stir(
        as_lanes(node), as_lanes(stream.flow), as_lanes(stream.push), as_lanes(stream.phase),
        stream.eddy_cm_s, as_lanes(water),
    )  # fmt: skip
    _swing(
        Chains(as_lanes(node), as_lanes(velocity), as_lanes(rest), as_lanes(lean)),
        as_lanes(water), response, dt,
    )  # fmt: skip
    for lane in range(len(leaves)):
        for i in range(NODES):
            for axis in range(3):
                seaweed.node[leaves[lane], i, axis] = node[i, axis, lane]
                seaweed.velocity[leaves[lane], i, axis] = velocity[i, axis, lane]


@kernel
def _stir(
    node: Array, flow: Array, push: Array, phase: Array, eddy_cm_s: float, water: Array
) -> None:
    """Write the velocity of the water (m, 3) at each `node` (m, 3) but the root, in lanes."""
    for i in range(1, NODES):
        along = phase[0] - (6.2832 / EDDY_CM) * (node[i, 0] + 0.5 * node[i, 2])
        x = flow[0] + eddy_cm_s * sine(along) + push[i, 0]
        y = flow[1] + eddy_cm_s * sine(0.83 * along + 1.0) + push[i, 1]
        z = flow[2] + push[i, 2]
        share = TORRENT_CM_S / max(math.sqrt(x * x + y * y + z * z), TORRENT_CM_S)
        water[i, 0], water[i, 1], water[i, 2] = share * x, share * y, share * z


class Chains(NamedTuple):
    """Leaves whose numbers are lanes, with m nodes from the root to the tip."""

    node: Array  # (m, 3), cm
    velocity: Array  # (m, 3), cm/s
    rest: Array  # (m,), cm, of the spring below each node
    lean: Array  # (m, 3), direction of the buoyancy


@kernel
def _swing(chains: Chains, water: Array, response: Array, dt: float) -> None:
    """Move leaves by `dt` in `water` (m, 3), cm/s: springs, buoyancy, and f = μ_w (v - ẋ).

    Springs are explicit, with substeps short enough for the lightest node; drag is implicit.
    """
    h = dt / SUBSTEPS
    node, velocity, lean = chains.node, chains.velocity, chains.lean
    lift, ground = h * BUOYANCY_CM_S2, node[0, 2] + 2.0
    for _ in range(SUBSTEPS):
        fx = fy = fz = zero_of(node)  # pull of the spring above, on the node below it
        for i in range(NODES - 1, 0, -1):
            dx = node[i, 0] - node[i - 1, 0]
            dy = node[i, 1] - node[i - 1, 1]
            dz = node[i, 2] - node[i - 1, 2]
            length = math.sqrt(dx * dx + dy * dy + dz * dz)
            inverse = 1.0 / max(length, 1e-6)
            dx, dy, dz = dx * inverse, dy * inverse, dz * inverse
            parting = (
                dx * (velocity[i, 0] - velocity[i - 1, 0])
                + dy * (velocity[i, 1] - velocity[i - 1, 1])
                + dz * (velocity[i, 2] - velocity[i - 1, 2])
            )
            pull = SPRING * (length - chains.rest[i]) + DAMPING * parting
            share, drag = response[i, 0], response[i, 1]
            flow = share * VISCOSITY
            gx, gy, gz = pull * dx, pull * dy, pull * dz
            velocity[i, 0] = drag * (
                velocity[i, 0] + share * (fx - gx) + lift * lean[i, 0] + flow * water[i, 0]
            )
            velocity[i, 1] = drag * (
                velocity[i, 1] + share * (fy - gy) + lift * lean[i, 1] + flow * water[i, 1]
            )
            velocity[i, 2] = drag * (
                velocity[i, 2] + share * (fz - gz) + lift * lean[i, 2] + flow * water[i, 2]
            )
            fx, fy, fz = gx, gy, gz
        for i in range(1, NODES):
            for axis in range(3):
                node[i, axis] += h * velocity[i, axis]
            # A leaf that is pressed down lies on the ground.
            rising = max(velocity[i, 2], 0.0)
            velocity[i, 2] = rising + where_positive(node[i, 2] - ground, velocity[i, 2] - rising)
            node[i, 2] = max(node[i, 2], ground)


@kernel
def _enclose(seaweed: Seaweed, sea: Sea, k: int) -> None:
    """Write the bounding box of cluster k."""
    box = sea.seaweed[k]
    for axis in range(3):
        low, high = np.inf, -np.inf
        for leaf in range(seaweed.first[k], seaweed.first[k + 1]):
            for i in range(NODES):
                low = min(low, seaweed.node[leaf, i, axis])
                high = max(high, seaweed.node[leaf, i, axis])
        box[axis], box[axis + 3] = low, high
