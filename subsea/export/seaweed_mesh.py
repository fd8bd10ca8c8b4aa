"""Seaweed as meshes, as `shaders/seaweed.vert` bends it at one moment."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.frame.in_sight import LEAF_NODES
from subsea.habitat.seaweed import KINDS
from subsea.rendering.reef.seaweed import COARSE, FINE, FRONDS_AT, fronds_of, ribbon

RIBBON, KELP, GRASS, RED = range(4)
FEW = 2  # of FRONDS_AT: near, without close-ups
# From the shader.
FLOAT, STIPES, BLADES, BRANCHES = 0.14, 3, 48, 15
BLADE_LENGTH, CANOPY_LENGTH = (5.0, 3.5), (9.0, 7.0)
CANOPY_CM, TALL_CM = (-150.0, -70.0), 450.0
LEAST_CM = 0.01  # of a frond: those of a canopy that is not there are points
# From `seaweed.frag`: darker roots and paler tips.
ROOT, TIP = np.array([0.75, 0.8, 0.8]), np.array([1.35, 1.15, 1.0])


class FrondMesh(NamedTuple):
    """The fronds of one kind."""

    kind: str
    points: Array  # (n, 3) cm, world
    normals: Array  # (n, 3)
    colors: Array  # (n, 3) linear
    triangles: Ints  # (m, 3)


class _Frond(NamedTuple):
    """A frond before its ribbon is spread: v vertices."""

    along: Array  # (v, 3) unit
    side: Array  # (v, 3)
    place: Array  # (v, 3) cm
    share: Array  # (v,) of its length
    width: Array  # (v,) cm
    length: float  # cm
    colour: Array  # (v, 3) or (3,)
    frilled: Array | float  # (v,)


def frond_meshes(leaves: Array, coarse: bool, eye: Array, time_s: float) -> list[FrondMesh]:
    """The fronds on all leaves (k, 10, 4), which are texels of a packet, kind by kind.

    Stems are ribbons that face `eye` (3,).
    """
    place, triangles = ribbon(*(COARSE if coarse else FINE))
    place = place.astype(np.float64)
    seen = np.ones((1, len(leaves)), np.bool_)
    fronds, _ = fronds_of(leaves, seen, 0, len(leaves), FRONDS_AT[FEW])
    texels = leaves.astype(np.float64)
    found = []
    for kind, name in enumerate(KINDS):
        shapes = []
        for row, number in ((int(row[0]), int(row[1])) for row in fronds):
            leaf = texels[row]
            if leaf[0, 3] != kind:
                continue
            own = (leaf[LEAF_NODES, 3] + 0.618 * number) % 1.0
            frond = _frond(kind, leaf, number, place[:, 0], eye, time_s)
            if np.ptp(frond.place, axis=0).max() > LEAST_CM:
                shapes.append(_spread(kind, frond, own, leaf[LEAF_NODES, 0], place[:, 1]))
        if shapes:
            points, normals, colours = (np.concatenate(part) for part in zip(*shapes, strict=True))
            first = np.arange(len(shapes))[:, None, None] * len(place)
            corners = _facing((first + triangles).reshape(-1, 3), points, normals)
            found.append(FrondMesh(name, points, normals, colours, corners))
    return found


def _facing(triangles: Ints, points: Array, normals: Array) -> Ints:
    """Triangles (m, 3) turned to the side of their normals."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    turned = (np.cross(b - a, c - a) * normals[triangles].sum(axis=1)).sum(axis=1) < 0.0
    return np.where(turned[:, None], triangles[:, ::-1], triangles).astype(np.int32)


def _frond(kind: int, leaf: Array, number: int, t: Array, eye: Array, time_s: float) -> _Frond:
    """The middle line of a frond, its width and colour; `t` (v,) is the share of its length."""
    wide, facing, twist, identity = leaf[LEAF_NODES]
    colour, long = leaf[LEAF_NODES + 1, :3], float(leaf[LEAF_NODES + 1, 3])
    own = (identity + 0.618 * number) % 1.0
    azimuth = 6.2832 * identity + 2.4 * number
    out_way = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    stem = number < STIPES if kind == KELP else number == 0
    turn = facing + twist * t
    side = np.stack([np.cos(turn), np.sin(turn), 0.0 * t], axis=1)
    if kind in (KELP, RED) and not stem:
        at = 1.0 - 0.12 * own
        if kind == RED:
            at = 0.08 + 0.75 * number / BRANCHES
        elif number < STIPES + BLADES:
            at = 0.05 + 0.95 * (number - STIPES + 1.0 - 0.4 * own) / BLADES
        return _branch(kind, leaf, number, t, at, side if kind == RED else eye, time_s)
    place, along = _curve(leaf[:LEAF_NODES, :3], t * (0.5 + 0.5 * own) if kind == GRASS else t)
    # Narrow at the root, widest below the middle, pointed.
    width = wide * (0.22 + 1.05 * np.sqrt(t)) * np.sqrt(np.maximum(1.0 - t, 0.0))
    width *= 1.0 - 0.25 * t
    if kind == GRASS:
        place = place + wide * (1.0 + 7.0 * own) * (0.5 + 0.6 * t**2)[:, None] * out_way
        along = _unit(along + 0.25 * t[:, None] * out_way)
        side = np.broadcast_to((-out_way[1], out_way[0], 0.0), place.shape)
        width = 0.35 * wide * (1.0 - t**2)
        return _Frond(along, side, place, t, width, long, colour * (0.75 + 0.5 * own), 0.0)
    if kind == KELP:
        eyeward = _unit(eye - place)
        place = place + _beside(number, t, identity, wide)
        width = wide * (0.19 * (1.0 - 0.55 * t) + 0.5 * np.maximum(1.0 - 14.0 * t, 0.0))
        dark = np.array([0.55, 0.5, 0.5])
        shade = dark + (1.0 - dark) * _smooth(0.0, 0.3, t)[:, None]
        return _Frond(along, np.cross(along, eyeward), place, t, width, long, colour * shade, 0.0)
    if kind == RED:
        width = wide * (0.45 + 0.3 * np.sin(3.0 * t)) * (1.0 - 0.5 * t)
    return _Frond(along, side, place, t, width, long, colour, 1.0)


def _branch(
    kind: int, leaf: Array, number: int, t: Array, at: float, toward: Array, time_s: float
) -> _Frond:
    """A frond that grows from a stem at the share `at`: away, then down and along with the water.

    `toward` is of kelp the eye (3,), of others the way (v, 3) across the ribbon of the stem.
    """
    wide, identity = leaf[LEAF_NODES, 0], leaf[LEAF_NODES, 3]
    colour, long = leaf[LEAF_NODES + 1, :3], leaf[LEAF_NODES + 1, 3]
    own, kelp = (identity + 0.618 * number) % 1.0, kind == KELP
    azimuth = 6.2832 * identity + 2.4 * number
    out_way = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    canopy = kelp and number >= STIPES + BLADES
    place, along = (np.repeat(one, len(t), axis=0) for one in _curve(leaf[:8, :3], np.array([at])))
    eyeward = _unit(toward - place) if kelp else toward
    size = grown = 1.0
    s = t  # along it
    if kelp:
        s = np.where(t < 0.25, FLOAT * t / 0.25, FLOAT + (1.0 - FLOAT) * (t - 0.25) / 0.75)
        place = place + _beside((number - STIPES) % STIPES, np.array([at]), identity, wide)
        least, more = CANOPY_LENGTH if canopy else BLADE_LENGTH
        length = wide * (least + more * own)
        # The youngest, at the tip, are small; old ones are dark.
        if canopy:
            size = float(_smooth(*CANOPY_CM, place[0, 2]))
        else:
            grown = float(np.clip(long / TALL_CM, 1.0, 1.7))
            length *= grown - 0.45 * float(_smooth(0.8, 1.0, np.array(at)))
        old = np.array([0.62, 0.60, 0.66])
        colour = colour * (old + at * ([1.15, 1.1, 1.0] - old)) * (0.75 + 0.5 * ((7.0 * own) % 1.0))
    else:
        length = long * (0.62 - 0.55 * at) * (0.7 + 0.5 * own)
        out_way = (1.0 if number % 2 == 0 else -1.0) * toward + 0.35 * out_way
    length *= size
    way = _unit(0.9 * out_way + (0.7 + 0.5 * own if kelp else 0.8) * along)
    bend = 0.4 * along
    if kelp:
        bend = np.concatenate([0.6 * along[:, :2], np.full((len(t), 1), -0.35 - 0.3 * own)], axis=1)
    flap = 2.1 * time_s - 5.0 * s + 6.2832 * own
    wave = np.stack([np.sin(flap), np.cos(0.8 * flap), 0.5 * np.sin(1.3 * flap)], axis=1)
    wave *= 0.06 if kelp else 0.03
    column = s[:, None]
    if canopy:
        # Up to the surface, and along it with the water.
        drift = leaf[LEAF_NODES - 1, :2] - leaf[0, :2] + 0.5 * long * 0.2 * out_way[:2]
        drift = drift / np.linalg.norm(drift)
        up = -3.0 - 7.0 * own - place[:, 2]
        way = np.broadcast_to((*(0.75 * drift), 0.0), place.shape)
        bend = np.broadcast_to((*(0.35 * out_way[:2]), 0.0), place.shape)
        fall = np.exp(-5.0 * s)
        place = place + (up * size * (1.0 - fall))[:, None] * (0.0, 0.0, 1.0)
        rise = np.stack([way[:, 0] * length, way[:, 1] * length, 5.0 * up * fall + 1e-3], axis=1)
        place = place + length * (column * way + column**2 * (bend + wave))
        along = _unit(_unit(rise) + wave * (0.0, 0.0, 0.2))
    else:
        place = place + length * (column * way + column**2 * (bend + wave))
        along = _unit(way + 2.0 * column * (bend + wave))
    if not kelp:
        width = wide * (0.35 + 0.5 * np.sin(3.0 * t)) * (1.0 - 0.6 * t)
        across = np.stack([-out_way[:, 1], out_way[:, 0], 0.3 + 0.0 * t], axis=1)
        return _Frond(along, np.cross(along, across), place, t, width, length, colour, 1.0)
    # A float, and the blade behind it.
    blade = np.clip((s - FLOAT) / (1.0 - FLOAT), 0.0, 1.0)
    width = grown * wide * 1.75 * np.sqrt(blade * (1.0 - blade)) * (1.0 - 0.45 * blade)
    ball = np.sin(3.1416 * np.minimum(s / FLOAT, 1.0))
    if canopy:
        side = np.stack([-along[:, 1], along[:, 0], 0.4 * np.sin(9.0 * own) + 0.0 * s], axis=1)
    else:
        leaning = _unit(np.array([[-0.5 * out_way[1], 0.5 * out_way[0], 1.0]]))
        side = np.cross(along, leaning)
    floats = t < 0.25
    width = size * np.where(floats, 0.07 * wide + 0.3 * wide * ball, width)
    side = np.where(floats[:, None], np.cross(along, eyeward), side)
    bladder = 0.4 * colour + 0.6 * np.array([0.20, 0.16, 0.05])
    colours = np.where(floats[:, None], bladder, colour)
    return _Frond(along, side, place, s, width, length, colours, np.where(floats, 0.0, 1.4))


def _spread(kind: int, one: _Frond, own: float, wide: float, y: Array) -> tuple[Array, ...]:
    """Points, normals and colours (v, 3) of a ribbon; `y` (v,) is from -1 to 1 across it."""
    along, t = one.along, one.share
    side = one.side - along * (along * one.side).sum(axis=1, keepdims=True)
    skew = np.stack([along[:, 1], -along[:, 0], 0.3 + 0.0 * t], axis=1)
    side = _unit(side + 1e-4 * skew)
    normal = np.cross(along, side)
    frill = 6.2832 * (t * one.length / (5.0 + 1.6 * wide) + own)
    edge = y * _smooth(0.05, 0.3, t) * one.frilled
    wave = np.where(y > 0.0, np.sin(frill), np.sin(1.13 * frill + 2.0))
    flat = np.minimum(one.frilled, 1.0)
    ragged = 1.0 + 0.13 * flat * np.sin(2.7 * frill + 5.0 * y) * t
    shift = (0.5 * ragged * y)[:, None] * side
    shift = shift + (np.abs(edge) * (0.20 * wave + 0.12))[:, None] * normal
    place = one.place + one.width[:, None] * shift
    if kind == KELP:  # beneath the surface, which bends it over
        high = place[:, 2] > -10.0
        place[high, 2] = -4.0 - 6.0 * np.exp(-(place[high, 2] + 10.0) / 6.0)
    normal = normal - side * (edge * (0.8 * wave + 0.45))[:, None]
    normal = _unit(normal + ((1.0 - flat) * y)[:, None] * side)
    return place, normal, one.colour * (ROOT + (TIP - ROOT) * t[:, None])


def _curve(nodes: Array, t: Array) -> tuple[Array, Array]:
    """Points and unit tangents (v, 3) of Catmull and Rom's curve through nodes (8, 3)."""
    last = LEAF_NODES - 1
    s = t * last
    k = np.clip(s.astype(int), 0, last - 1)
    s = (s - k)[:, None]
    a, b, c, d = (nodes[np.clip(k + step, 0, last)] for step in (-1, 0, 1, 2))
    p1, p2 = 0.5 * (c - a), a - 2.5 * b + 2.0 * c - 0.5 * d
    p3 = 0.5 * (d - a) + 1.5 * (b - c)
    return b + s * (p1 + s * (p2 + s * p3)), _unit(p1 + s * (2.0 * p2 + 3.0 * s * p3))


def _beside(stipe: float, t: Array, own: float, wide: float) -> Array:
    """Shifts (v, 3), cm: the stipes of one holdfast wind about its chain."""
    turn = 2.0944 * stipe + 6.2832 * own + 4.0 * t
    away = wide * (0.25 + 2.2 * t * (1.4 - t))
    return np.stack([away * np.cos(turn), away * np.sin(turn), 0.0 * t], axis=1)


def _unit(rows: Array) -> Array:
    return np.asarray(rows / np.linalg.norm(rows, axis=-1, keepdims=True))


def _smooth(start: float, end: float, x: Array | float) -> Array:
    t = np.clip((np.asarray(x) - start) / (end - start), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))
