"""What an interrupted recording has done already, so that the next run goes on from there.

Each finished segment lies beside the repertoire to come, as ``.SPECIES.SEGMENT.recording``: a
repertoire of that one segment. All of them are removed when the whole repertoire is written. Two
processes may record one species at once: a file that one of them removes the other can write
again, as it could not in a folder that is gone.
"""

from contextlib import suppress
from pathlib import Path

from capture.recording.fingerprint import fingerprint
from capture.recording.record import Recorded, assemble
from subsea.core.errors import UserError
from subsea.fish.species import Species
from subsea.repertoire import SEGMENTS, Repertoire, read_repertoire, write_repertoire


def repertoire_path(folder: Path, name: str) -> Path:
    """The repertoire of the species ``name`` in ``folder``."""
    return folder / f"{name}.h5"


def is_up_to_date(folder: Path, name: str, species: Species) -> bool:
    """Whether the repertoire of a species is whole and was recorded from just this species."""
    repertoire = _read(repertoire_path(folder, name), name, species)
    return repertoire is not None and set(SEGMENTS) <= repertoire.segments.keys()


def save_segment(
    folder: Path, name: str, species: Species, segment: str, recorded: Recorded
) -> None:
    """Keep a finished segment; UserError where it cannot be written."""
    write_repertoire(_kept(folder, name, segment), assemble(name, species, {segment: recorded}))


def finished_segments(folder: Path, name: str, species: Species) -> dict[str, Recorded]:
    """The segments kept of a species; what is damaged or of another fish is left out."""
    found = {}
    for segment in SEGMENTS:
        one = _read(_kept(folder, name, segment), name, species)
        if one is not None and segment in one.segments:
            found[segment] = one.segments[segment], one.provenance["warm_up_beats"][segment]
    return found


def remove_segments(folder: Path, name: str) -> None:
    """Forget what is kept of a species."""
    for segment in SEGMENTS:
        with suppress(OSError):  # it is not there, or another process is first
            _kept(folder, name, segment).unlink()


def _kept(folder: Path, name: str, segment: str) -> Path:
    return folder / f".{name}.{segment}.recording"


def _read(path: Path, name: str, species: Species) -> Repertoire | None:
    """The repertoire at ``path`` if it was recorded from this species by this program."""
    try:
        repertoire = read_repertoire(path)
    except UserError:  # missing, damaged or of another version: to be recorded again
        return None
    found = repertoire.species, repertoire.provenance.get("fingerprint")
    return repertoire if found == (name, fingerprint(species)) else None
