"""Record a species by its form: a fish that bends, a flatfish, or a boxfish."""

from types import ModuleType

from capture.recording import boxfish, flatfish, record
from capture.recording.record import Recorded
from subsea.fish.species import Species
from subsea.repertoire import Repertoire

MODULES: dict[str, ModuleType] = {"fish": record, "flatfish": flatfish, "boxfish": boxfish}


def segments_of(species: Species) -> tuple[str, ...]:
    """The segments that are recorded of a species, in the order of SEGMENTS."""
    names: tuple[str, ...] = MODULES[species.form].segments_of(species)
    return names


def record_segment(species: Species, name: str) -> Recorded:
    """Record one segment of a species."""
    found: Recorded = MODULES[species.form].record_segment(species, name)
    return found


def assemble(name: str, species: Species, recorded: dict[str, Recorded]) -> Repertoire:
    """Make a repertoire of recorded segments; its provenance suffices to record them again."""
    made: Repertoire = MODULES[species.form].assemble(name, species, recorded)
    return made
