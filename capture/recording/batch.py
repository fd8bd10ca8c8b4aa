"""Record several species: only what is missing, and whole files only."""

from collections.abc import Callable, Mapping
from contextlib import closing
from pathlib import Path

from capture.recording.record import Recorded, assemble, segments_of
from capture.recording.resume import (
    finished_segments,
    is_up_to_date,
    remove_segments,
    repertoire_path,
    save_segment,
)
from capture.recording.workers import Workers
from subsea.fish.species import load_species
from subsea.jobs.workers import Check
from subsea.repertoire import write_repertoire


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
