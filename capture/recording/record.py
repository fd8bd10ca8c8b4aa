"""Record a species' repertoire: swims, turns, escapes, starts and stops (SMC §4.3)."""

from typing import Any, NamedTuple

import msgspec
import numpy as np

from capture.recording.fingerprint import fingerprint, library_versions
from capture.recording.segment import record_spine_segment, spine_segments
from capture.recording.spine_motion import nodes_at_rest
from subsea.biomechanics.body import build_body
from subsea.biomechanics.body_plan import BodyPlan, Muscles, SwimPlan, TurnPlan
from subsea.biomechanics.coasting import row_turn
from subsea.biomechanics.controllers import RIGHT
from subsea.biomechanics.manoeuvres import mirrored
from subsea.biomechanics.rowing import oars_of, row_ticks
from subsea.biomechanics.simulation import at_rest
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK, TICK_S, TIME_UNIT_S
from subsea.biomechanics.trial import Trial
from subsea.fish.skinning import Coupling, couple
from subsea.fish.species import Species
from subsea.fish.spine import SpinePlan
from subsea.fish.surface import SurfacePlan, rest_control_points
from subsea.repertoire import SEGMENTS, Repertoire, Segment
from subsea.repertoire.schema import ACYCLIC
from subsea.repertoire.segments import make_segment, run_trial, side_of

Motion = Muscles  # the three plans that determine how a species moves
ROWED = ("row_forward", "turn_left_row", "turn_right_row")  # segments of species that row


def row_trial(species: Species, name: str) -> Trial:
    """One steady stroke of the pectoral fins; ValueError for a species that does not row."""
    motion, fin = motion_of(species), species.surface.pectoral
    if not (species.row and fin):
        raise ValueError(f"{species.name} does not row")
    body, length = build_body(motion.body), motion.body.length
    size = fin.length * length, fin.width * length
    if name != "row_forward":
        oars = oars_of(body, species.row, size)
        trial = row_turn(motion, oars, species.row.ticks_per_stroke)
        return mirrored(trial) if side_of(name) == RIGHT else trial
    steps = row_ticks(body, species.row, size)
    frames = np.repeat(body.rest[None], len(steps) + 1, axis=0)
    frames[1:, :, 0] += np.cumsum(steps)[:, None]
    return Trial(frames, at_rest(body))


class Recorded(NamedTuple):
    """A segment, the number of its warm-up beats, and how a turn bends."""

    segment: Segment
    warm_up_beats: int = 0
    bend: tuple[float, ...] = ()  # `biomechanics.manoeuvres.Bend`


def record_segment(species: Species, name: str) -> Recorded:
    """Record one segment of a species.

    Of muscle-driven species only schooling ones store control points, as in SMC §4.1.
    """
    if species.spine:
        return Recorded(record_spine_segment(species.spine, species.surface, name))
    motion = motion_of(species)
    grade = name.rpartition("_")[2]
    trial = row_trial(species, name) if name in ROWED else run_trial(motion, name)
    segment = make_segment(
        trial.frames,
        species.length_cm,
        pattern="left" if "left" in name else "right" if "right" in name else "forward",
        grade=grade,
        cyclic=grade not in ACYCLIC,
        coupling=_surface_coupling(species.surface, motion.body) if species.schooling else None,
        slowing=trial.slowing,
    )
    return Recorded(segment, trial.warm_up_beats, trial.bend)


def _surface_coupling(surface: SurfacePlan, body: BodyPlan) -> Coupling:
    """Couple the 426 control points of a surface to the nodes of a body (SMC eq. 9, Tu §5.4)."""
    nodes = build_body(body).rest
    return couple(surface.coupling, nodes, rest_control_points(surface, body.length, nodes[0, 0]))


def motion_of(species: Species) -> Motion:
    """The plans of a species with muscles; ValueError without."""
    if species.muscles is None:
        raise ValueError(f"{species.name} has no muscles")
    return species.muscles


def motion_from_provenance(provenance: dict[str, Any]) -> Motion:
    """The plans that a repertoire was recorded from; msgspec.ValidationError without them."""
    return Motion(
        msgspec.convert(provenance.get("body"), BodyPlan),
        msgspec.convert(provenance.get("swim"), SwimPlan),
        msgspec.convert(provenance.get("turn"), TurnPlan),
    )


def spine_from_provenance(provenance: dict[str, Any]) -> tuple[SpinePlan, SurfacePlan]:
    """The plans of a spine-driven fish; msgspec.ValidationError without them."""
    plans = provenance.get("spine"), provenance.get("surface")
    return msgspec.convert(plans[0], SpinePlan), msgspec.convert(plans[1], SurfacePlan)


def segments_of(species: Species) -> tuple[str, ...]:
    """The segments that are recorded of a species, in the order of SEGMENTS."""
    if species.spine:
        return spine_segments(species.spine)
    missing = set() if species.row else set(ROWED)
    if "burst" not in motion_of(species).swim.grades:
        missing.add("swim_burst")
    return tuple(name for name in SEGMENTS if name not in missing)


def record_species(name: str, species: Species) -> Repertoire:
    """Record the whole repertoire of a species in this process."""
    segments = {segment: record_segment(species, segment) for segment in segments_of(species)}
    return assemble(name, species, segments)


def assemble(name: str, species: Species, recorded: dict[str, Recorded]) -> Repertoire:
    """Make a repertoire of recorded segments; its provenance suffices to record them again."""
    if species.spine:
        source, rest = "spine", nodes_at_rest(species.spine, species.surface)
        plans = {"spine": species.spine, "surface": species.surface}
    else:
        motion = motion_of(species)
        source, rest, plans = "biomechanics", build_body(motion.body).rest, motion._asdict()
        if species.row:
            plans["row"] = species.row
    return Repertoire(
        species=name,
        tick_s=TICK_S,
        body_length_cm=species.length_cm,
        source=source,
        provenance={
            "tool": "subsea-capture",
            "versions": library_versions(),
            "fingerprint": fingerprint(species),
            "seed": None,  # nothing in a recording is random
            "step_tu": STEP,
            "steps_per_tick": STEPS_PER_TICK,
            "time_unit_s": TIME_UNIT_S,
            "bends": {name: one.bend for name, one in sorted(recorded.items()) if one.bend},
            "warm_up_beats": {name: one.warm_up_beats for name, one in sorted(recorded.items())},
            **{key: msgspec.to_builtins(plan) for key, plan in plans.items()},
        },
        rest_nodes=rest,
        segments={
            segment: recorded[segment].segment for segment in SEGMENTS if segment in recorded
        },
    )
