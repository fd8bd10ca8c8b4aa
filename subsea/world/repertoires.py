"""Read the species and repertoires of a scenario; cache each file until it changes."""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from subsea.base.disk_cache import cached
from subsea.base.errors import UserError
from subsea.base.files import file_hash
from subsea.fish.forms import couple_surface
from subsea.fish.skinning import Coupling
from subsea.fish.species import Species, load_species, repertoire_file, species_file
from subsea.motor.switching import Dynamics, make_dynamics
from subsea.repertoire import Repertoire
from subsea.repertoire.library import LIVE_TABLES, Library, pack
from subsea.world.world import TICK_S

LIVE_ROWS = (*LIVE_TABLES, "control_points", "facing")  # tables with rows of simulated fishes


def species_of(name: str) -> Species:
    """Return a species by name, read again only if its file has changed."""
    path = species_file(name)
    return _species(path, file_version(path))


def repertoire_of(name: str) -> Repertoire:
    """Return the repertoire of a species, read again only if its file has changed."""
    path = repertoire_file(name)
    return _repertoire(path, name, file_version(path))


class RecordedMotion(NamedTuple):
    """Constants that worlds of the same species share. Nothing writes into them."""

    species: tuple[Species, ...]
    library: Library  # without rows of simulated fishes
    dynamics: Dynamics  # with any reach


def motion_of(names: Sequence[str]) -> RecordedMotion:
    """Return the motion of some species, packed again only if one of their files has changed."""
    files = [(name, species_file(name), repertoire_file(name)) for name in names]
    return _motion(
        tuple((*named, file_version(named[1]), file_version(named[2])) for named in files)
    )


def with_live(library: Library, live: int) -> Library:
    """Append the rows of `live` simulated fishes to those of a library."""
    longer: dict[str, Any] = {}
    for name in LIVE_ROWS if live else ():
        rows = getattr(library, name)
        longer[name] = np.concatenate([rows, np.zeros((2 * live, *rows.shape[1:]), rows.dtype)])
    return library._replace(**longer)


def coupling_of(species: Species, repertoire: Repertoire) -> Coupling:
    """Couple the surface of a species to the nodes that its repertoire records."""
    length, nodes = repertoire.body_length_cm, repertoire.rest_nodes
    return couple_surface(species.form, species.surface, length, nodes)


def file_version(path: Path) -> tuple[int, int] | None:
    """Return the time and size of a file, which change with its content; None without a file."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=1)  # of the bay 100 MB
def _motion(files: tuple[tuple[object, ...], ...]) -> RecordedMotion:
    """Pack the motion of species by name."""
    names = [str(name) for name, *_ in files]
    species = {name: species_of(name) for name in names}
    repertoires = [repertoire_of(name) for name in names]
    library = pack(repertoires, [coupling_of(species[r.species], r) for r in repertoires])
    every = tuple(species.values())
    return RecordedMotion(every, library, make_dynamics(every, repertoires, library, 0.0))


@lru_cache(maxsize=64)
def _species(path: Path, stamp: object) -> Species:
    """Read a species."""
    return load_species(str(path))


@lru_cache(maxsize=64)
def _repertoire(path: Path, name: str, stamp: object) -> Repertoire:
    """Read a repertoire, which must be of the named species and have frames of a tick."""
    if stamp is None:
        raise UserError(f"is not there; `subsea-capture record {name}` makes it", file=path)

    # Named after the content, not the path: a wheel carries the results of its repertoires.
    def read(content: str) -> Repertoire:
        from subsea.repertoire import read_repertoire

        repertoire = read_repertoire(path)
        if file_hash(path) != content:
            raise UserError("changed while it was read; start again", file=path)
        return repertoire

    repertoire = cached(read, file_hash(path))
    if repertoire.species != name:
        raise UserError(f"holds {repertoire.species!r}, expected {name!r}", file=path)
    if abs(repertoire.tick_s - TICK_S) > 1e-6:
        raise UserError(f"tick_s is {repertoire.tick_s:g}, expected {TICK_S:g}", file=path)
    return repertoire
