"""Record several species: only what is missing, and whole files only.

Record segments in this process, in other processes or on a Dask cluster, with the same result.

A job is one segment of one species. Workers are functions that take jobs and yield each with its
result, in any order.

Save finished segments, so that an interrupted recording can continue.

Each is a repertoire of one segment, ``.SPECIES.SEGMENT.recording`` beside the final file, and is
removed when that is written. A folder for them could be removed by another process.
"""

from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing, suppress
from pathlib import Path

from capture.recording.fingerprint import fingerprint
from capture.recording.forms import assemble, record_segment, segments_of
from capture.recording.record import Recorded
from subsea.base.errors import UserError
from subsea.fish.species import Species, load_species
from subsea.jobs import workers
from subsea.jobs.dask_cluster import dask_pool
from subsea.jobs.workers import Check
from subsea.repertoire import SEGMENTS, Repertoire, read_repertoire, write_repertoire
from subsea.repertoire.findings import CALM

Job = tuple[str, str]  # names of species and segment
Results = Generator[tuple[Job, Recorded], None, None]
Workers = Callable[[Mapping[Job, Species], Check], Results]


def record_job(job: Job, species: Species) -> Recorded:
    """Record the segment of a job; UserError with its names if the fish cannot swim."""
    try:
        return record_segment(species, job[1])
    except UserError as fault:
        raise type(fault)(f"{job[0]}, {job[1]}: {fault}. {CALM}") from fault


def record_equally(given: tuple[Job, Species, str]) -> Recorded:
    """Record a segment if the worker has the version of the caller, by the fingerprint."""
    job, species, expected = given
    if fingerprint(species) != expected:
        raise UserError("a worker has another version of subsea, numpy or numba; install the same")
    return record_job(job, species)


def serial(jobs: Mapping[Job, Species], check: Check) -> Results:
    """Run the jobs in this process, one after another."""
    return _run(workers.serial, jobs, check)


def process_pool(number: int) -> Workers:
    """Workers in ``number`` processes of this computer.

    The job of a crashed process is repeated; UserError if it crashes each time.
    """
    pool = workers.process_pool(number)
    return lambda jobs, check: _run(pool, jobs, check)


def dask_workers(address: str, tls: Sequence[Path] | None = None) -> Workers:
    """Workers of the Dask cluster with a scheduler at ``address``; see `dask_pool`."""
    pool = dask_pool(address, tls)
    return lambda jobs, check: _run(pool, jobs, check)


def _run(pool: workers.Pool[Job], jobs: Mapping[Job, Species], check: Check) -> Results:
    given = {job: (job, species, fingerprint(species)) for job, species in jobs.items()}
    for job, result in pool(record_equally, given, check):
        if result is None:
            raise UserError(
                f"worker processes crashed {workers.MAX_ATTEMPTS} times; is there enough memory? "
                f"Not recorded: {' '.join(job)}"
            )
        yield job, result


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
                tuple(one.provenance["bends"].get(segment, ())),
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


def record_all(
    folders: Mapping[str, Path],
    workers: Workers,
    check: Check = lambda: None,
    progress: Callable[[str, int], object] = lambda name, segments: None,
    force: bool = False,
) -> list[str]:
    """Write the repertoires of species to their folders; return the names of those recorded.

    Those up to date are skipped without ``force``; segments of an interrupted run are reused.
    ``progress(species, segments)`` is called when the number of finished segments grows.
    """
    species = {name: load_species(name) for name in folders}
    done: dict[str, dict[str, Recorded]] = {}
    for name, one in species.items():
        if force:
            remove_segments(folders[name], name)
        elif is_up_to_date(folders[name], name, one):
            remove_segments(folders[name], name)  # a run killed at its end may have left them
            continue
        done[name] = finished_segments(folders[name], name, one)
        progress(name, len(done[name]))
    jobs = {
        (name, segment): species[name]
        for name, segments in done.items()
        for segment in segments_of(species[name])
        if segment not in segments
    }

    def finish(name: str) -> None:
        if len(done[name]) == len(segments_of(species[name])):
            repertoire = assemble(name, species[name], done[name])
            write_repertoire(repertoire_path(folders[name], name), repertoire)
            remove_segments(folders[name], name)

    for name in done:
        finish(name)
    with closing(workers(jobs, check)) as results:
        for (name, segment), recorded in results:
            save_segment(folders[name], name, species[name], segment, recorded)
            done[name][segment] = recorded
            progress(name, len(done[name]))
            finish(name)
    return list(done)
