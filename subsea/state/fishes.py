"""Bodies of the fishes: place, pose, motor state and the commands to the motor system."""

from typing import Annotated, NamedTuple

from subsea.core.kernels.struct_ref import Kind, by_pointer
from subsea.state.declaration import BOOL, F32, I8, I32, U8, behavior, creation, motor, written_by

UPRIGHT = (1.0, 0.0, 0.0, 0.0)
water = written_by("habitat, behavior")
ROW, SEGMENT = (0, "rows"), (0, "segments")


class FishesKind(Kind):
    """The compiler's type of `Fishes`."""


@by_pointer(FishesKind)
class Fishes(NamedTuple):
    """Bodies of the n fishes of a dive. Playback mixes two rows of the motion library."""

    species: Annotated[U8, creation("n"), "index into the scenario's species"]
    length: Annotated[F32, creation("n", unit="cm"), "body length"]
    scale: Annotated[F32, creation("n", start=1), "length over recorded length: α, SMC eq. 12"]
    rate: Annotated[F32, creation("n", start=1), "recorded rows per tick: large fishes beat slowly"]
    identity: Annotated[F32, creation("n"), "individual variation in [0, 1)"]
    snout: Annotated[F32, creation("n", unit="cm"), "x of the tip of the snout in body axes"]
    girth: Annotated[F32, creation("n", 2, unit="cm"), "height and width of the body without fins"]
    oars: Annotated[BOOL, creation("n"), "whether it rows with its pectoral fins (Tu appendix B.2)"]

    position: Annotated[F32, motor("n", 3, unit="cm"), "origin of the body frame B, world axes"]
    orientation: Annotated[F32, motor("n", 4, start=UPRIGHT), "quaternion, body to world axes"]
    row_a: Annotated[I32, motor("n", within=ROW), "the pose mixes rows a and b of the library"]
    row_b: Annotated[I32, motor("n", within=ROW), "see `row_a`"]
    weight: Annotated[F32, motor("n"), "share of row b in the pose, in [0, 1)"]
    span: Annotated[F32, motor("n", start=1), "frames from a to b: 1 in playback, more in a glide"]
    previous_position: Annotated[F32, motor("n", 3, unit="cm"), "one tick ago"]
    previous_orientation: Annotated[F32, motor("n", 4, start=UPRIGHT), "one tick ago"]
    previous_row_a: Annotated[I32, motor("n", within=ROW), "one tick ago"]
    previous_row_b: Annotated[I32, motor("n", within=ROW), "one tick ago"]
    previous_weight: Annotated[F32, motor("n"), "one tick ago"]
    previous_span: Annotated[F32, motor("n", start=1), "one tick ago"]
    velocity: Annotated[F32, motor("n", 3, unit="cm/s"), "of the body frame, world axes"]
    segment: Annotated[U8, motor("n", within=SEGMENT), "code of the segment of row b"]
    wanted_segment: Annotated[U8, motor("n", within=SEGMENT), "request of the secondary controller"]
    tempo: Annotated[F32, motor("n", start=1), "playback rate asked of the segment, about 1"]
    thrust: Annotated[
        F32, motor("n", start=1), "share of the recorded way: 1 swims, 0 hovers, negative retreats"
    ]
    glide_tempo: Annotated[F32, motor("n", start=1), "tempo at the start of the current glide"]
    glide_thrust: Annotated[F32, motor("n", start=1), "thrust at the start of the current glide"]
    steering: Annotated[F32, motor("n", 2, unit="rad/s"), "yaw and pitch added to the recording"]
    roll: Annotated[F32, motor("n", unit="rad"), "smoothed roll"]
    fin_phase: Annotated[F32, motor("n", 2, unit="rad"), "beat of the left and right pectoral fin"]
    breath: Annotated[F32, motor("n", unit="rad"), "phase of breathing"]
    fins: Annotated[F32, motor("n", 7), "columns SWEEP_LEFT to TAIL"]
    previous_fins: Annotated[F32, motor("n", 7), "one tick ago"]
    monotony: Annotated[F32, motor("n", unit="s"), "time in the same segment"]
    recommended: Annotated[
        I8,
        motor("n", start=-1, within=(-1, "segments")),
        "swim recommended against monotony, -1 for none",
    ]
    live: Annotated[BOOL, motor("n"), "whether it is simulated, not played back"]
    stay: Annotated[
        F32,
        motor("n", unit="s", start=float("inf")),
        "time since `live` changed, infinite for never",
    ]

    drift: Annotated[
        F32, water("n", 3, unit="cm/s"), "velocity imposed by water, suction or a line, world axes"
    ]

    alive: Annotated[
        BOOL,
        behavior("n", start=True),
        "False once it was eaten or landed; then nobody perceives it",
    ]
    goal_direction: Annotated[F32, behavior("n", 3), "unit vector, world axes"]
    goal_speed: Annotated[F32, behavior("n"), "share of the fast swim's speed; negative retreats"]
    gape: Annotated[F32, behavior("n"), "opening of the mouth asked for, in [0, 1]"]
    display: Annotated[F32, behavior("n"), "strength of the mating colours, in [0, 1]"]
