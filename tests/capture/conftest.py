from pathlib import Path

import pytest

from capture.recording.record import record_species
from subsea.fish.species import Species, load_species
from subsea.repertoire import Repertoire, write_repertoire

NAMES = ["emperor_angelfish", "fusilier"]


@pytest.fixture(scope="session")
def repertoires() -> dict[str, Repertoire]:
    return {name: record_species(name, load_species(name)) for name in NAMES}


@pytest.fixture(scope="session", params=NAMES)
def name(request: pytest.FixtureRequest) -> str:
    species: str = request.param
    return species


@pytest.fixture(scope="session")
def species(name: str) -> Species:
    return load_species(name)


@pytest.fixture(scope="session")
def repertoire(name: str, repertoires: dict[str, Repertoire]) -> Repertoire:
    return repertoires[name]


@pytest.fixture(scope="session")
def recorded(repertoires: dict[str, Repertoire], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A freshly recorded repertoire file of the fusilier."""
    path = tmp_path_factory.mktemp("recorded") / "fusilier.h5"
    write_repertoire(path, repertoires["fusilier"])
    return path
