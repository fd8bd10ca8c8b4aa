"""Recordings that cost less: each segment once, and turns without the search that found them."""

from collections.abc import Callable
from functools import cache

from capture.recording.batch import is_up_to_date
from capture.recording.record import Recorded, record_segment
from subsea.base.system import resource_path
from subsea.biomechanics import manoeuvres
from subsea.biomechanics.body_plan import Muscles
from subsea.biomechanics.trial import Trial
from subsea.fish.species import Species, load_species, shipped_species
from subsea.repertoire import Repertoire, Segment, read_repertoire
from subsea.repertoire.transitions import Transitions, plan_transitions

search = manoeuvres._left_turn


@cache
def shipped_motion(motion: Muscles) -> Repertoire | None:
    """The repertoire that is shipped for a fish, if this code recorded it."""
    folder = resource_path("repertoires")
    for name in shipped_species():
        species = load_species(name)
        if species.muscles == motion and is_up_to_date(folder, name, species):
            return read_repertoire(folder / f"{name}.h5")
    return None


@cache
def known_turn(motion: Muscles, left: str, rounds: int) -> Trial:
    """The turn that the search finds: only the bend of the file is tried.

    It is searched for a fish that is not shipped, or after a change of the code that records.
    """
    shipped = shipped_motion(motion)
    if shipped is None or rounds < manoeuvres.ROUNDS:
        return search(motion, left, rounds)
    return manoeuvres.Turner(motion, left).swim(manoeuvres.Bend(*shipped.provenance["bends"][left]))


def forget_turns() -> None:
    """Forget the turns of this process, after other constants made them."""
    known_turn.cache_clear()
    search.cache_clear()


@cache
def planner() -> Callable[[list[Segment]], Transitions]:
    """Plan the transitions between the same segments once."""
    known: dict[tuple[bytes, ...], Transitions] = {}

    def plan(segments: list[Segment]) -> Transitions:
        parts = (
            (one.grade.encode(), one.nodes, one.increment_translation, one.increment_rotation)
            for one in segments
        )
        key = tuple(bytes(part) for one in parts for part in one)
        if key not in known:
            known[key] = plan_transitions(segments)
        return known[key]

    return plan


def each_once(known: dict[str, Recorded]) -> Callable[[Species, str], Recorded]:
    """Record segments in place of `record_segment`; what was recorded is known from then on."""

    def record(species: Species, segment: str) -> Recorded:
        key = f"{segment} of {species}"
        if key not in known:
            known[key] = record_segment(species, segment)
        return known[key]

    return record
