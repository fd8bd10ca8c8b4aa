"""Measure the repertoire of a spine-driven fish against its plan."""

from collections.abc import Iterator

import numpy as np

from capture.inspection.simulated import REPLAYED_CYCLES, replay
from capture.inspection.targets import Measure, at_least, at_most, compare, within
from capture.recording.record import spine_from_provenance
from capture.recording.spine_segments import motion_of_segment
from subsea.biomechanics.body_frame import body_frame
from subsea.fish.spine import SpinePlan
from subsea.fish.surface import SurfacePlan
from subsea.repertoire import Repertoire


def measure_spine_driven(repertoire: Repertoire) -> Iterator[Measure]:
    """Measures of a complete repertoire with the source `spine`.

    msgspec.ValidationError where the provenance holds no plan. Swimming speed has no target: it
    is part of the plan.
    """
    plan, surface = spine_from_provenance(repertoire.provenance)
    segments = repertoire.segments
    speeds = [segments[f"swim_{grade}"].speed_cm_s for grade in ("slow", "medium", "fast")]
    yield compare("medium over slow", speeds[1] / speeds[0], ".2f", " ×", at_least(1.4))
    yield compare("fast over medium", speeds[2] / speeds[1], ".2f", " ×", at_least(1.4))
    for grade, asked in (("gradual", plan.turn.gradual), ("sharp", plan.turn.sharp)):
        left, right = (segments[f"turn_{side}_{grade}"].turn_deg for side in ("left", "right"))
        name = f"{grade} turn of {asked:g}°, left and right"
        yield compare(name, (left - asked, -right - asked), "+.3f", "°", within(1), within(0.1))
    cyclic = [name for name, segment in segments.items() if segment.cyclic]
    closure = max(segments[name].loop_error_bl for name in cyclic)
    yield compare("loop closure, worst cycle", closure, ".1e", " L", at_most(1e-3), at_most(1e-5))
    errors = [_spine_replay_error(plan, surface, repertoire, name) for name in cyclic]
    name = f"{REPLAYED_CYCLES} cycles replayed against the plan"
    yield compare(name, max(errors) / plan.length, ".1e", " L", at_most(0.01), at_most(1e-4))
    nodes = motion_of_segment(plan, surface, "swim_fast").nodes
    tail = nodes[:, 21:].mean(axis=1)[:, 2]
    yield Measure("tail sweep, fast", f"{np.ptp(tail) / plan.length:.3f} L")


def _spine_replay_error(
    plan: SpinePlan, surface: SurfacePlan, repertoire: Repertoire, name: str
) -> float:
    """Largest error of a node after some cycles of replay, cm."""
    nodes = motion_of_segment(plan, surface, name).nodes
    origin, rotation = body_frame(nodes)
    replayed = replay(repertoire.segments[name], origin[0], rotation[0], REPLAYED_CYCLES)[-1]
    # Each cycle moves the fish by the same rigid motion.
    turn = rotation[-1] @ rotation[0].T
    step = origin[-1] - turn @ origin[0]
    last = nodes[-1]
    for _ in range(REPLAYED_CYCLES - 1):
        last = last @ turn.T + step
    return float(np.linalg.norm(replayed - last, axis=1).max())
