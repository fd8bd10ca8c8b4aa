"""Record the segments of a spine-driven species (KS part II)."""

from capture.recording.spine_manoeuvre import spine_manoeuvre
from capture.recording.spine_motion import SpineMotion, spine_motion
from capture.recording.spine_muscles import muscle_motion
from capture.recording.wing_muscles import ray_of, wing_motion
from subsea.fish.spine import SpinePlan
from subsea.fish.surface import SurfacePlan
from subsea.repertoire import BASIC_SEGMENTS, SEGMENTS, Segment
from subsea.repertoire.schema import ACYCLIC
from subsea.repertoire.segments import make_segment

FIN_GRADES = ("forward", "row", "coast")  # of segments that need muscles or pectoral fins
GLIDES = ("turn_left_glide", "turn_right_glide")


def spine_segments(plan: SpinePlan) -> tuple[str, ...]:
    """The segments of a species, in the order of SEGMENTS.

    A ray never rests, and does not row. Without water there are only the basic ones.
    """
    if plan.medium.slip is not None:
        return BASIC_SEGMENTS
    if plan.wings:
        names = {*BASIC_SEGMENTS, *GLIDES, "swim_burst"}
    else:
        names = {name for name in SEGMENTS if name.rpartition("_")[2] not in FIN_GRADES}
    if plan.burst is None:
        names -= {"swim_burst"}
    return tuple(name for name in SEGMENTS if name in names)


def record_spine_segment(plan: SpinePlan, surface: SurfacePlan, name: str) -> Segment:
    """Record the segment ``name`` with control points: 23 nodes are too few for eels and rays."""
    _, _, grade = name.rpartition("_")
    motion = motion_of_segment(plan, surface, name)
    return make_segment(
        motion.nodes,
        plan.length,
        pattern="left" if "left" in name else "right" if "right" in name else "forward",
        grade=grade,
        cyclic=grade not in ACYCLIC,
        surface=motion.points,
    )


def motion_of_segment(plan: SpinePlan, surface: SurfacePlan, name: str) -> SpineMotion:
    """Compute all frames of a segment: by muscles, along a path, or free."""
    _, _, grade = name.rpartition("_")
    if plan.muscles:
        return muscle_motion(plan, surface, name)
    if plan.wings and plan.wings.muscles:
        if grade == "glide":  # the wings are still
            return spine_motion(plan, surface, name, ray_of(plan, surface).pace(plan.medium))
        return wing_motion(plan, surface, name)
    free = grade in ACYCLIC and grade != "sharp" and not plan.wings
    return (spine_manoeuvre if free else spine_motion)(plan, surface, name)
