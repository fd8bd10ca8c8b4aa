"""The provenance of a run."""

import hashlib

from subsea import __version__
from subsea.fish.species import repertoire_file, species_file
from subsea.lab import simulate
from subsea.lab.provenance import provenance_of
from subsea.scenario.load import load_scenario
from tests.support.scenes import BARE


def test_hashes_are_those_of_the_files():
    changes = ["fish.0.number=3"]
    scenario, source, _ = load_scenario(str(BARE), changes)
    found = provenance_of(scenario, source, changes, simulate.__file__)
    assert found.program == f"subsea {__version__}"
    assert found.changes == ("fish.0.number=3",)
    assert "number = 3" in found.scenario and "number = 4" not in found.scenario
    assert found.scenario_sha256 == hashlib.sha256(BARE.read_bytes()).hexdigest()
    assert found.species_keys == ("clownfish", "fusilier")
    for place, hashes in (
        (species_file, found.species_sha256),
        (repertoire_file, found.repertoire_sha256),
    ):
        contents = [place(name).read_bytes() for name in found.species_keys]
        assert hashes == tuple(hashlib.sha256(one).hexdigest() for one in contents)


def test_the_code_is_that_of_the_module():
    scenario, source, _ = load_scenario(str(BARE))
    hashes = {
        provenance_of(scenario, source, (), file).code_sha256
        for file in (simulate.__file__, provenance_of.__code__.co_filename)
    }
    assert len(hashes) == 2
