import shutil
from pathlib import Path

import pytest

from capture.recording.batch import save_segment
from capture.recording.record import assemble, record_segment, segments_of
from subsea.base.system import resource_path
from subsea.biomechanics.manoeuvres import TURNS
from subsea.fish.species import load_species
from subsea.repertoire import read_repertoire

NAMES = ["emperor_angelfish", "fusilier"]
SHIPPED = resource_path("repertoires")


@pytest.fixture(scope="session")
def segments(known_turns):
    """The recorded segments of each species."""
    every = {name: load_species(name) for name in NAMES}
    return {
        name: {segment: record_segment(species, segment) for segment in segments_of(species)}
        for name, species in every.items()
    }


@pytest.fixture(scope="session")
def repertoires(segments):
    return {name: assemble(name, load_species(name), found) for name, found in segments.items()}


@pytest.fixture
def save_turns(segments):
    """Leave what an interrupted recording left: the turns, which are long to search."""

    def save(name, folder):
        turns = [turn for left in TURNS for turn in (left, left.replace("_left_", "_right_"))]
        for turn in turns:
            save_segment(folder, name, load_species(name), turn, segments[name][turn])
        return len(turns)

    return save


@pytest.fixture(scope="session", params=NAMES)
def name(request):
    species: str = request.param
    return species


@pytest.fixture(scope="session")
def species(name):
    return load_species(name)


@pytest.fixture(scope="session")
def repertoire(name):
    """The repertoire that is shipped: tests/repertoire shows that it would be recorded again."""
    return read_repertoire(SHIPPED / f"{name}.h5")


@pytest.fixture(scope="session")
def recorded(tmp_path_factory):
    """A copy of the repertoire file of the fusilier."""
    return Path(shutil.copy(SHIPPED / "fusilier.h5", tmp_path_factory.mktemp("recorded")))
