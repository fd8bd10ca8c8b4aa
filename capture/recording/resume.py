"""Save finished segments, so that an interrupted recording can continue.

Each is a repertoire of one segment, ``.SPECIES.SEGMENT.recording`` beside the final file, and is
removed when that is written. A folder for them could be removed by another process.
"""

from contextlib import suppress
from pathlib import Path

from capture.recording.fingerprint import fingerprint
from capture.recording.record import Recorded, assemble, segments_of
from subsea.base.errors import UserError
from subsea.fish.species import Species
from subsea.repertoire import SEGMENTS, Repertoire, read_repertoire, write_repertoire


def repertoire_path(folder: Path, name: str) -> Path:
    """The repertoire of the species ``name`` in ``folder``."""
    return folder / f"{name}.h5"


def is_up_to_date(folder: Path, name: str, species: Species) -> bool:
    """True if the repertoire is complete and was recorded from exactly this species."""
    repertoire = _read(repertoire_path(folder, name), name, species)
    return repertoire is not None and set(segments_of(species)) <= repertoire.segments.keys()


def save_segment(
    folder: Path, name: str, species: Species, segment: str, recorded: Recorded
) -> None:
    """Save a finished segment; UserError where it cannot be written."""
    write_repertoire(
        _segment_path(folder, name, segment), assemble(name, species, {segment: recorded})
    )


def finished_segments(folder: Path, name: str, species: Species) -> dict[str, Recorded]:
    """The saved segments of a species; damaged ones and those of other fishes are skipped."""
    found = {}
    for segment in segments_of(species):
        one = _read(_segment_path(folder, name, segment), name, species)
        if one is not None and segment in one.segments:
            found[segment] = Recorded(
                one.segments[segment],
                one.provenance["warm_up_beats"][segment],
                one.provenance["couples"].get(segment, 0.0),
            )
    return found


def remove_segments(folder: Path, name: str) -> None:
    """Remove the saved segments of a species."""
    for segment in SEGMENTS:
        with suppress(OSError):  # missing, or removed by another process
            _segment_path(folder, name, segment).unlink()


def _segment_path(folder: Path, name: str, segment: str) -> Path:
    return folder / f".{name}.{segment}.recording"


def _read(path: Path, name: str, species: Species) -> Repertoire | None:
    """The repertoire at ``path``, if this program recorded it from this species."""
    try:
        repertoire = read_repertoire(path)
    except UserError:  # missing, damaged or of another version
        return None
    found = repertoire.species, repertoire.provenance.get("fingerprint")
    return repertoire if found == (name, fingerprint(species)) else None
