"""Surroundings of the fishes: seabed, solids, plankton, seaweed, reef and the hook."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from subsea.core.kernels.struct_ref import Kind, by_pointer
from subsea.state.codes import NOBODY, STOWED
from subsea.state.declaration import (
    BOOL,
    F32,
    F64,
    I32,
    I64,
    NUMBER,
    U8,
    creation,
    habitat,
    written_by,
)

eaten = written_by("habitat, behavior")
hooked = written_by("habitat, behavior, directing")


class SeaKind(Kind):
    """The compiler's type of `Sea`."""


@by_pointer(SeaKind)
class Sea(NamedTuple):
    """Everything around the fishes that they may perceive."""

    heights: Annotated[
        F32, creation("m", "m", unit="cm"), "seabed: row i along y, column j along x"
    ]
    floor: Annotated[F32, creation("m", "m", unit="cm"), "seabed with all that grows on it"]
    half_width: Annotated[
        NUMBER, creation(unit="cm"), "w: the height field spans [-w, w] in x and y"
    ]
    radius: Annotated[NUMBER, creation(unit="cm"), "of the cylinder that bounds the sea"]
    pillars: Annotated[F64, creation("k", 4, unit="cm"), "x, y, radius, height of the top"]
    rocks: Annotated[F64, creation("k", 7, unit="cm"), "ellipsoid: centre, half axes, yaw in rad"]
    climate: Annotated[
        F64,
        creation(4),
        "°C at the surface, °C at the depth, that depth and 1/e depth of light, cm",
    ]

    plankton: Annotated[F32, habitat("p", 3, unit="cm"), "places of specks"]
    absent: Annotated[
        F32, eaten("p", unit="s"), "time until an eaten speck is back, 0: it is there"
    ]
    seaweed: Annotated[
        F32, habitat("c", 6, unit="cm"), "lowest and highest corner of each cluster's bounding box"
    ]

    submarine: Annotated[
        F64, written_by("world")(9), "place, cm, velocity, cm/s, unit vector ahead"
    ]

    tackle: Annotated[
        F64,
        creation(5, start=(0.0, 0.0, 0.0, 0.0, np.inf)),
        "hook: x, y, depth, cm, speed, cm/s, time of its start, s",
    ]
    hook: Annotated[F64, written_by("habitat, directing")(3, unit="cm"), "place of the bait"]
    catch: Annotated[
        I64,
        hooked(2, start=(STOWED, NOBODY), within=(NOBODY, "catch")),
        "state of the hook, STOWED to LANDED, and fish on it, or NOBODY",
    ]

    crest: Annotated[
        NUMBER, creation(unit="cm", start=np.inf), "highest point of the seabed inside the sea"
    ]


class Seaweed(NamedTuple):
    """Seaweed (Tu §8.2): l leaves in c clusters, each a chain of m nodes from root to tip."""

    first: Annotated[
        I32, creation("c + 1"), "cluster k has the leaves first[k] to first[k + 1] - 1"
    ]
    rest: Annotated[
        F32,
        creation("l", "m - 1", unit="cm"),
        "rest length from node to node, shrinking toward the tip",
    ]
    lean: Annotated[F32, creation("l", "m", 3), "unit vectors of each node's buoyancy"]
    look: Annotated[
        F32, creation("l", 8), "width, cm; facing and twist, rad; own number; colour; length"
    ]
    kind: Annotated[U8, creation("l"), "index into `habitat.seaweed.KINDS`"]
    cell_cm: Annotated[
        NUMBER, creation(unit="cm"), "side of square cells, row by row from the south-west corner"
    ]
    cell_first: Annotated[I32, creation("cells + 1"), "start of each cell's list in `cell_cluster`"]
    cell_cluster: Annotated[I32, creation("entries"), "clusters that a fish in a cell may touch"]

    node: Annotated[F32, habitat("l", "m", 3, unit="cm"), "places of the nodes, world axes"]
    previous: Annotated[F32, habitat("l", "m", 3, unit="cm"), "one tick ago"]
    velocity: Annotated[F32, habitat("l", "m", 3, unit="cm/s"), "of the nodes, world axes"]


class Reef(NamedTuple):
    """Corals, sponges and anemones: k growths, biggest first."""

    kind: Annotated[U8, creation("k"), "index into `habitat.reef.KINDS`"]
    place: Annotated[F32, creation("k", 3, unit="cm"), "foot, slightly below the ground"]
    axis: Annotated[F32, creation("k", 3), "unit vector of growth"]
    turn: Annotated[F32, creation("k", unit="rad"), "rotation about the axis"]
    radius: Annotated[F32, creation("k", unit="cm"), "size"]
    own: Annotated[F32, creation("k"), "individual variation in [0, 1)"]
    light: Annotated[F32, creation("k"), "share of the sky's light that solids let through"]
    hue: Annotated[F32, creation("k"), "colour in [0, 1), similar to neighbours of its kind"]
    on_rock: Annotated[BOOL, creation("k"), "whether it stands on rock, not on sand"]

    def taken(self, chosen: Any) -> "Reef":
        """Growths chosen by an index, slice or mask."""
        return Reef(*(part[chosen] for part in self))
