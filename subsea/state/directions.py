"""Progress of a scenario's directions."""

from typing import Annotated, NamedTuple

from subsea.state.codes import COURTSHIP, NOBODY, SUBMARINE
from subsea.state.declaration import BOOL, F64, I32, I64, U8, U16, directing

COUNT = 2**31 - 1


class Directions(NamedTuple):
    """Progress of the k directions of a scenario among n fishes; all empty without directions."""

    began: Annotated[
        I64,
        directing("k", unit="tick", start=-1, within=(-1, 2**48 + 1)),
        "when it last began, -1 for never",
    ]
    times: Annotated[I32, directing("k", within=(0, COUNT + 1)), "how often it has begun"]
    ready: Annotated[BOOL, directing("k"), "whether its condition held in the last tick"]
    running: Annotated[BOOL, directing("k"), "whether it still acts"]
    ceded: Annotated[
        U16,
        directing("k", within=(0, "influences")),
        "INFLUENCES that later directions took over, bits",
    ]
    stage: Annotated[
        I32, directing("k", within=(0, COUNT)), "next point of its path, or stage of a pair"
    ]
    cast: Annotated[
        I32,
        directing("k", 2, start=NOBODY, within=(SUBMARINE, "n")),
        "fishes it is about, NOBODY or SUBMARINE",
    ]
    current: Annotated[F64, directing("axes", unit="cm/s"), "added to the strength of the current"]
    alive: Annotated[BOOL, directing("n", start=True), "`Fishes.alive` after the last tick"]
    courtship: Annotated[
        U8, directing("n", within=(0, len(COURTSHIP))), "`Minds.courtship` after the last tick"
    ]
