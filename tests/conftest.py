"""Shared fixtures: a fish whose motion is known in closed form, and worlds of it."""

import gc
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import settings
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.base.progress import say
from subsea.behavior.table import BEHAVIORS, TABLE
from subsea.biomechanics.body import body_frame, to_body
from subsea.dive.warm_up import warm_up
from subsea.geometry.rotation import from_matrix
from subsea.repertoire import BASIC_SEGMENTS, Repertoire, Segment
from subsea.scenario.schema import NatureTable
from subsea.state import Clock, Fishes, Minds, Nature, Sea, empty

pytest_plugins = ["tests.support.windows"]

# The first example of a test may compile a kernel, so time is not a measure of a failure.
settings.register_profile("daily", deadline=None, derandomize=True, max_examples=25)
settings.register_profile("nightly", settings.get_profile("daily"), max_examples=200)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let pictures be accepted: `pytest tests/rendering --regenerate`."""
    parser.addoption(
        "--nightly", action="store_true", help="run also the tests that are long by nature"
    )
    parser.addoption(
        "--regenerate", action="store_true", help="store the pictures of tests/rendering again"
    )
    parser.addoption(
        "--differences", type=Path, help="write a JSON file with the differences of the pictures"
    )


def pytest_configure(config: pytest.Config) -> None:
    """No test, nor what it starts, sees the species and scenarios of the user who runs it."""
    settings.load_profile("nightly" if config.getoption("--nightly") else "daily")
    gc.set_threshold(50_000, 20, 20)  # thousands of tests are many objects to look through
    folder = TemporaryDirectory()
    config.add_cleanup(folder.cleanup)
    os.environ["XDG_DATA_HOME"] = folder.name
    if config.getoption("numprocesses", None):  # else each of them would compile the same kernels
        warm_up(say)
    # Else each of a hundred programs that tests start would compile Python's sources again.
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    # numpy's second thread doubles the processor time of small matrices, and gains nothing where
    # several processes test. This one has numpy already, those that it starts have not.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Nor do several processes that test gain from a tick's second thread: it costs a tenth more.
    os.environ.setdefault("SUBSEA_THREADS", "1")
    config.option.loadscopereorder = False  # of xdist: files are given out in the order below


# Files that take long, about the longest first; but those after the first need other kernels than
# that one, lest two processes that find none kept compile the same ones.
LONG = (
    "capture/recording/test_batch.py",
    "ui/test_menu.py",
    "docs/test_every_command.py",
    "export/test_web.py",
    "stage/cluster/test_master.py",
    "ui/test_manoeuvres.py",
    "export/test_gltf.py",
    "ui/test_window_set.py",
    "media/test_film.py",
    "stage/console/test_page.py",
    "stage/headset/test_headset_dive.py",
    "base/test_language.py",
    "dive/test_picking.py",
    "docs/test_site.py",
    "rendering/fish/test_fishes.py",
    "studio/skin_editor/test_window.py",
    "ui/panels/test_initialisation.py",
    "motor/test_dynamics.py",
    "world/test_feeding.py",
    "stage/calibration/test_calibrate.py",
)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Choose the tests of this run, and begin with long files, so that no process is last alone.

    `--differences` chooses the tests of stored pictures; tests marked `nightly` need `--nightly`.
    """
    if config.getoption("--differences"):
        items[:] = [item for item in items if "same_picture" in getattr(item, "fixturenames", ())]
    if not config.getoption("--nightly"):
        late = [item for item in items if item.get_closest_marker("nightly")]
        config.hook.pytest_deselected(items=late)
        items[:] = [item for item in items if item not in set(late)]
    here = Path(__file__).parent
    rank = {here / name: place for place, name in enumerate(LONG)}
    assert all(path.exists() for path in rank), "LONG names a file that is gone"
    items.sort(key=lambda item: rank.get(item.path, len(LONG)))


def pytest_collection_finish() -> None:
    """The tests themselves are there to the end: the garbage collector leaves them alone."""
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def nobodys_settings(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """No test, nor what it starts, goes by the settings of the user who runs it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CONFIG_HOME", str(tmp_path_factory.mktemp("config")))
        patch.setenv("LANGUAGE", "en")
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture(scope="session")
def certificate(tmp_path_factory):
    """A certificate of 127.0.0.1 that signs itself, and its key."""
    folder = tmp_path_factory.mktemp("tls")
    paths = folder / "cert.pem", folder / "key.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
         "-nodes", "-days", "2", "-subj", "/CN=127.0.0.1", "-addext",
         "subjectAltName=IP:127.0.0.1", "-out", str(paths[0]), "-keyout", str(paths[1])],
        check=True, capture_output=True,
    )  # fmt: skip
    return paths


@pytest.fixture(scope="session")
def known_turns() -> Iterator[None]:
    """Recordings of shipped fishes do not search again for the bends of their turns.

    Nor for transitions that they found before.
    """
    from subsea.biomechanics import manoeuvres
    from subsea.repertoire import files
    from tests.support.recording import known_turn, planner

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(manoeuvres, "_left_turn", known_turn)
        patch.setattr(files, "plan_transitions", planner())
        yield


TICK_S = 0.033
LENGTH = 20.0
STATIONS = np.array([0.0, 2.0, 5.0, 10.0, 14.7, 17.8, 20.0])
HALF_WIDTH = [0.4, 0.95, 1.2, 1.0, 0.75]
HALF_HEIGHT = [0.7, 1.25, 1.55, 1.5, 1.3]


def straight_nodes() -> NDArray[np.float64]:
    """The nodes (23, 3) of the prototype fish at rest, in body axes."""
    x = STATIONS[2] - STATIONS
    nodes = [[x[0], 0.0, 0.0]]
    for k, (w, h) in enumerate(zip(HALF_WIDTH, HALF_HEIGHT, strict=True), start=1):
        nodes += [[x[k], h, -w], [x[k], h, w], [x[k], -h, w], [x[k], -h, -w]]
    nodes += [[x[6], 2.1, 0.0], [x[6], -2.1, 0.0]]
    return np.array(nodes)


def swum_nodes(
    time: float, amplitude: float, frames: int, speed: float, turn: float
) -> NDArray[np.float64]:
    """World nodes (23, 3) of a fish on a circular path with a travelling wave, z up."""
    nodes = straight_nodes()
    phase = 2 * np.pi * time / frames
    back = (nodes[0, 0] - nodes[:, 0]) / LENGTH
    nodes[:, 2] += amplitude * LENGTH * back**2 * np.sin(phase - 5.0 * back)
    heading = turn * time
    if abs(turn) < 1e-12:
        place = np.array([speed * time, 0.0, 0.0])
    else:
        place = speed / turn * np.array([np.sin(heading), 1 - np.cos(heading), 0.0])
    # Body x, y, z to world: y is up, z is right.
    c, s = np.cos(heading), np.sin(heading)
    axes = np.array([[c, 0.0, s], [s, 0.0, -c], [0.0, 1.0, 0.0]])
    return place + nodes @ axes.T


def segment(pattern: str, grade: str, amplitude: float, speed: float, turn: float) -> Segment:
    """Twelve frames of the known motion, reduced as SMC eqs. 6-8 say."""
    frames = 12
    world = np.stack([swum_nodes(t, amplitude, frames, speed, turn) for t in range(frames + 1)])
    origin, rotation = body_frame(world)
    before = np.swapaxes(rotation[:-1], -1, -2)
    step = (before @ (origin[1:] - origin[:-1])[..., None])[..., 0]
    return Segment(
        pattern=pattern,
        grade=grade,
        cyclic=grade != "sharp",
        increment_rotation=from_matrix(before @ rotation[1:]),
        increment_translation=step,
        nodes=to_body(world[1:], origin[1:], rotation[1:]),
        control_points=None,
        speed_cm_s=speed / TICK_S,
        turn_deg=float(np.degrees(turn * frames)),
        loop_error_bl=0.0,
        bounding_radius_bl=0.85,
    )


@pytest.fixture(scope="session")
def known_repertoire() -> Repertoire:
    """A repertoire in closed form: seven segments of twelve frames."""
    fast = 20.0 * TICK_S
    forms = {
        "swim_slow": ("forward", "slow", 0.03, 0.3 * fast, 0.0),
        "swim_medium": ("forward", "medium", 0.06, 0.6 * fast, 0.0),
        "swim_fast": ("forward", "fast", 0.10, fast, 0.0),
        "turn_left_gradual": ("left", "gradual", 0.06, 0.5 * fast, np.radians(1.5)),
        "turn_left_sharp": ("left", "sharp", 0.08, 0.5 * fast, np.radians(5.0)),
        "turn_right_gradual": ("right", "gradual", 0.06, 0.5 * fast, np.radians(-1.5)),
        "turn_right_sharp": ("right", "sharp", 0.08, 0.5 * fast, np.radians(-5.0)),
    }
    return Repertoire(
        species="known",
        tick_s=TICK_S,
        body_length_cm=LENGTH,
        source="closed form",
        provenance={"by": "tests/conftest.py"},
        rest_nodes=straight_nodes(),
        segments={name: segment(*forms[name]) for name in BASIC_SEGMENTS},
    )


@pytest.fixture(scope="session")
def known_repertoire_nodes(known_repertoire: Repertoire) -> Array:
    """Its nodes at rest."""
    return known_repertoire.rest_nodes


@pytest.fixture(scope="session")
def known_motion() -> Callable[..., Any]:
    """The closed form itself: `swum_nodes`."""
    return swum_nodes


SEA_RADIUS, SEA_DEPTH = 1000.0, 600.0
SEABED = np.full((9, 9), -SEA_DEPTH, np.float32)


class Tank(NamedTuple):
    """The arguments of every desire and routine."""

    fishes: Fishes
    minds: Minds
    sea: Sea
    nature: Nature
    clock: Clock

    def at(self, tick: int) -> "Tank":
        """The same at another tick."""
        return self._replace(clock=Clock(self.clock.seed, tick, TICK_S))

    def run(self, routine: Any, *who: int) -> None:
        """Let a routine act on the fishes `who`, or on all."""
        chosen = np.array(who if who else range(len(self.fishes.species)), np.int64)
        routine(chosen, *self)

    def desire(self, function: Any) -> np.ndarray:
        """A desire of each fish."""
        out = np.zeros(len(self.fishes.species), np.float32)
        function(np.arange(len(out)), *self, out)
        return out


def make_tank(
    n: int = 1, seed: int = 1, specks: int = 0, pillars: Any = (), rocks: Any = (), **nature: float
) -> Tank:
    """`n` fishes of 20 cm in the middle of a flat sea, bound along x at 15 cm/s."""
    fishes, minds = empty(Fishes, n=n), empty(Minds, n=n, b=len(BEHAVIORS), d=len(TABLE.desires))
    fishes.length[:] = 20.0
    fishes.snout[:] = 7.0
    fishes.girth[:] = 5.0, 2.0
    fishes.position[:] = 0.0, 0.0, -300.0
    # Upright, along x: body y is up, body z to the right.
    fishes.orientation[:] = np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0
    fishes.velocity[:] = 15.0, 0.0, 0.0
    fishes.goal_direction[:] = 1.0, 0.0, 0.0
    fishes.goal_speed[:] = 0.5
    minds.urge[:] = 1.0, 0.0, 0.0
    minds.waypoint[:] = fishes.position
    minds.pause[:] = TICK_S
    minds.dread[:] = 200.0
    given = {
        "heights": SEABED, "floor": SEABED, "half_width": 1.6 * SEA_RADIUS, "radius": SEA_RADIUS,
        "pillars": np.array(pillars, np.float64).reshape(-1, 4),
        "rocks": np.array(rocks, np.float64).reshape(-1, 7),
        "climate": np.array([27.0, 21.0, SEA_DEPTH, 700.0]),
        "submarine": np.array([0.0, 0.0, 1e6, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
    }  # fmt: skip
    sea = empty(Sea, given=given, p=specks, c=0, s=0, q=0)
    constants = {name: getattr(NatureTable(), name) for name in Nature._fields}
    return Tank(fishes, minds, sea, Nature(**(constants | nature)), Clock(seed, 1, TICK_S))


@pytest.fixture(scope="session")
def tank() -> Any:
    """The tank itself, for a number of fishes, specks and solids."""
    return make_tank
