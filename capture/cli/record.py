"""`subsea-capture record`: swim fishes and write their repertoires."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, number_reader
from subsea.base.errors import UserError, unknown
from subsea.base.file_kinds import check_results, hdf5_file
from subsea.base.files import check_folder
from subsea.base.interrupts import deferred_interrupts
from subsea.base.system import resource_path

MAX_JOBS = 64


GROUP = "record and measure"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    from subsea.jobs.dask_cluster import add_cluster

    parser = add_command(
        commands,
        "record",
        "record the motion of species",
        "Simulates the swims, turns and escapes of each species and writes the repertoire\n"
        "OUT/SPECIES.h5. Skips repertoires that are up to date; an interrupted run continues\n"
        "where it stopped.",
        [
            "subsea-capture record fusilier",
            "subsea-capture record --all --jobs 2",
            "subsea-capture record --all --cluster tcp://192.168.1.5:8786",
            "subsea-capture record emperor_angelfish --out /tmp/repertoires",
        ],
    )
    parser.add_argument("species", metavar="SPECIES", nargs="*", help="species to record")
    parser.add_argument("--all", action="store_true", help="record every shipped species")
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help="folder to write to (default: where dives look for them)",
    )
    parser.add_argument(
        "--jobs",
        metavar="N",
        type=number_reader(int, 1, MAX_JOBS),
        default=1,
        help="parallel processes (default 1)",
    )
    add_cluster(parser)
    parser.add_argument(
        "--force",
        action="store_true",
        help="record up-to-date species too, and replace existing files of any kind",
    )
    parser.add_argument(
        "--progress", action="store_true", help="show progress even without a terminal"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from capture.recording.batch import dask_workers, process_pool, repertoire_path, serial
    from subsea.fish.species import shipped_species, species_names
    from subsea.repertoire.schema import FORMAT

    known = species_names()
    for name in options.species:
        if name not in known:
            raise unknown("species", name, known)
    if options.all and options.species:
        raise UserError(f"--all and {options.species[0]!r}: give one of the two")
    if options.cluster is not None and options.jobs != 1:
        raise UserError("--jobs and --cluster: give one of the two")
    if options.cluster is None and options.cluster_tls is not None:
        raise UserError("--cluster-tls needs --cluster")
    if not options.all and not options.species:
        raise UserError(f"name a species ({', '.join(known)}) or give --all")
    names = shipped_species() if options.all else list(dict.fromkeys(options.species))
    folders = {name: options.out or folder_of(name) for name in names}
    for folder in dict.fromkeys(folders.values()):
        check_folder(folder)
    if options.out is not None:
        kind = hdf5_file("a repertoire", FORMAT)
        check_results([repertoire_path(options.out, name) for name in names], kind, options.force)
    if options.cluster is not None:
        workers = dask_workers(options.cluster, options.cluster_tls)
    else:
        workers = serial if options.jobs == 1 else process_pool(options.jobs)
    record(folders, workers, options.progress, options.force)
    return 0


def record(folders: Mapping[str, Path], workers: Any, progress: bool, force: bool) -> None:
    """Record species, by name, to folders with `workers`, show progress and print warnings.

    A bar is shown on a terminal, with ``progress`` always.
    """
    from tqdm import tqdm

    from capture.recording.batch import record_all, repertoire_path
    from capture.recording.forms import segments_of
    from subsea.fish.species import load_species
    from subsea.repertoire import read_repertoire
    from subsea.repertoire.findings import FishMotion, complaints

    bars: dict[str, Any] = {}

    def show(name: str, segments: int) -> None:
        if name not in bars:
            bars[name] = tqdm(
                total=len(segments_of(load_species(name))),
                desc=name,
                position=len(bars),
                unit="segment",
                initial=segments,
                disable=False if progress else None,
            )
        bars[name].update(segments - bars[name].n)

    try:
        with deferred_interrupts() as check:
            recorded = record_all(folders, workers, check, show, force)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("run the same command to continue") from None
    finally:
        for bar in bars.values():
            bar.close()
    for name, folder in folders.items():
        path = repertoire_path(folder, name)
        print(f"{path}{'' if name in recorded else ': up to date'}")
        repertoire = read_repertoire(path)
        if repertoire.source == "boxfish":  # limits are those of a tail that beats
            continue
        motion = FishMotion(repertoire.segments, repertoire.body_length_cm)
        for words in complaints(motion):
            print(f"  warning: {words}")


def folder_of(name: str) -> Path:
    """The folder to record a species to; UserError for one of an installed package."""
    from subsea.fish.species import is_shipped, repertoire_folder

    if is_shipped(name) and not resource_path("pyproject.toml").is_file():
        raise UserError("name the folder to write to: --out DIR")
    return repertoire_folder(name)
