"""The inputs of a run: code, packages, scenario, species and repertoires."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np

from subsea import __version__
from subsea.base.files import file_hash
from subsea.base.source_stamp import source_stamp
from subsea.fish.species import repertoire_file, species_file
from subsea.scenario.save import scenario_text
from subsea.scenario.schema import Scenario


class Provenance(NamedTuple):
    """Versions and hashes of everything that a run is made from, except its seed and length."""

    program: str
    packages: str  # versions of packages that may change a result
    code_sha256: str
    scenario: str  # its text, with the changes
    scenario_sha256: str  # of its file, without them
    changes: tuple[str, ...]
    species_keys: tuple[str, ...]
    species_sha256: tuple[str, ...]  # of the file of each
    repertoire_sha256: tuple[str, ...]


def provenance_of(
    scenario: Scenario, source: Path, changes: Sequence[str], module: str
) -> Provenance:
    """The provenance of a run of a scenario from the file `source`.

    `module` is the file of the code that makes the result. A missing file is a UserError.
    """
    names = tuple(scenario.species)
    return Provenance(
        program=f"subsea {__version__}",
        packages=f"numpy {np.__version__}, numba {numba.__version__}",
        code_sha256=source_stamp(Path(module).resolve()),
        scenario=scenario_text(scenario, source),
        scenario_sha256=file_hash(source),
        changes=tuple(changes),
        species_keys=names,
        species_sha256=tuple(file_hash(species_file(name)) for name in names),
        repertoire_sha256=tuple(file_hash(repertoire_file(name)) for name in names),
    )
