"""Fishes that are simulated instead of played back."""

from typing import Annotated, NamedTuple

from subsea.state.declaration import F32, F64, I32, motor


class Live(NamedTuple):
    """k slots for simulated fishes, at the size and pace of the recorded fish.

    Each slot owns two rows behind the recorded ones of the library, for this pose and the next.
    A fish keeps its slot until the glide back to playback has left the slot's rows.
    """

    fish: Annotated[
        I32, motor("k", start=-1, within=(-1, "n")), "index of the fish, -1 for a free slot"
    ]
    waiting: Annotated[
        I32,
        motor("k", unit="tick", within=(0, 2**31 - 1)),
        "time for which it has waited to leave, 0: it stays",
    ]
    x: Annotated[F64, motor("k", 23, 3, unit="cm"), "nodes relative to the origin of B, world axes"]
    v: Annotated[F64, motor("k", 23, 3, unit="cm/tu"), "velocity relative to the water"]
    phase: Annotated[F64, motor("k", unit="rad"), "of the beat"]
    tempo: Annotated[F64, motor("k", start=1), "of the beat, 1 is the recorded one"]
    amplitude: Annotated[F64, motor("k"), "of the beat, 1 is grade fast"]
    bend: Annotated[F64, motor("k", 2), "contractions of the two turning segments, left positive"]
    speed: Annotated[F64, motor("k", unit="cm/s"), "smoothed, along x, of the recorded fish"]
    rotation: Annotated[F32, motor("2 k", 4), "rows of the library: rotation of B per frame"]
    translation: Annotated[
        F32, motor("2 k", 3, unit="cm"), "rows of the library: way of B per frame"
    ]
    nodes: Annotated[F32, motor("2 k", 23, 3, unit="cm"), "rows of the library: pose in body axes"]
