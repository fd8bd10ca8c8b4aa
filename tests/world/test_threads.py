"""The same world on any number of threads and any processor, bit for bit."""

import os
import subprocess
import sys

import pytest

from subsea.base.system import resource_path
from subsea.behavior import table
from subsea.kernels.threads import _Pool, use_threads
from subsea.perception import focusser, senses
from subsea.perception import senses as scheduling
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import Helm
from subsea.world import levels, step
from subsea.world.build import create_world
from subsea.world.snapshot import checksum
from tests.support.daily import only

SCENARIOS = sorted(path.stem for path in resource_path("assets/scenarios").glob("*.toml"))
TICKS, MOST_FISHES = 30, 60
AHEAD = Helm(surge=0.4)


@pytest.fixture
def small_parts(monkeypatch):
    """Cut a hundred fishes into as many parts as a hundred thousand."""
    for module in (step, senses, focusser, scheduling, table, levels):
        monkeypatch.setattr(module, "LEAST_PART", 5)
    for name in ("LEAST_MINDS", "LEAST_SPECKS", "LEAST_CLUSTERS"):
        monkeypatch.setattr(step, name, 5)
    monkeypatch.setattr(senses, "LEAST_HUNTERS", 1)
    monkeypatch.setattr(senses, "LEAST_GRIDS", 1)
    yield
    use_threads()


def _dive(name, threads, ticks=TICKS, most=MOST_FISHES, levels=False):
    """Checksums of a dive, one every 15 ticks."""
    use_threads(threads)
    scenario = load_scenario(name)[0]
    number = sum(shoal.number for shoal in scenario.fish)
    world = create_world(scenario, fish=most if number > most else None)
    world.levels = levels
    found = []
    for tick in range(ticks):
        step.step(world, AHEAD)
        if tick % 15 == 14:
            found.append(checksum(world))
    return found


@pytest.mark.parametrize("name", only(("mating",), SCENARIOS))
def test_the_number_of_threads_does_not_matter(small_parts, name):
    alone = _dive(name, 1)
    for threads in (2, 3, 16):
        assert _dive(name, threads) == alone


@pytest.mark.nightly
@pytest.mark.parametrize("name", only(("open-ocean",), SCENARIOS))
def test_the_number_of_threads_does_not_matter_with_levels(small_parts, name):
    alone = _dive(name, 1, levels=True)
    if name == "open-ocean":  # small seas may have no fish beyond the nearest level
        assert alone != _dive(name, 1)
    for threads in (2, 16):
        assert _dive(name, threads, levels=True) == alone


@pytest.mark.nightly
@pytest.mark.parametrize("name", only(("open-ocean",), SCENARIOS))
def test_the_order_of_parts_does_not_matter(small_parts, monkeypatch, name):
    """A kernel that reads what other rows write in the same pass differs without any race."""
    ordered = _dive(name, 3, 90, 10**6)
    monkeypatch.setattr(_Pool, "run", lambda self, tasks: [task() for task in reversed(tasks)])
    assert _dive(name, 3, 90, 10**6) == ordered


@pytest.mark.nightly
def test_it_does_not_matter_for_ten_seconds(small_parts):
    """Long enough for captures and courtships."""
    for name in ("preying", "mating"):
        assert _dive(name, 3, 300) == _dive(name, 1, 300)


@pytest.mark.nightly
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("name", SCENARIOS)
def test_it_does_not_matter_for_all_fishes(small_parts, name):
    alone = _dive(name, 1, 300, 10**6)
    for threads in (2, 3, 16):
        assert _dive(name, threads, 300, 10**6) == alone


# Of the libraries, which have one for each core in the process of the tests.
ONE_THREAD = {"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
# Libraries choose their code by the processor. These settings stand for older and newer ones.
PROCESSORS = {
    "numpy": {"NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4"},
    "OpenBLAS": {"OPENBLAS_CORETYPE": "Nehalem"},
    "the C library": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-ERMS"},
}
PROCESSORS["all"] = {key: value for given in PROCESSORS.values() for key, value in given.items()}
CHILD = """
import sys
from tests.world.test_threads import _dive
for name in sys.argv[1:]:
    print(_dive(name, 1)[-1])
"""


@pytest.mark.nightly
@pytest.mark.skipif(sys.platform != "linux", reason="the C library of other systems has no setting")
@pytest.mark.parametrize("library", sorted(PROCESSORS))
def test_neither_the_processor_nor_threads_of_libraries_matter(library):
    done = subprocess.run(
        [sys.executable, "-c", CHILD, *SCENARIOS],
        env=os.environ | ONE_THREAD | PROCESSORS[library],
        capture_output=True,
        text=True,
        check=True,
    )
    try:
        assert done.stdout.split() == [str(_dive(name, 1)[-1]) for name in SCENARIOS]
    finally:
        use_threads()
