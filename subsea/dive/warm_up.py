"""Compile the kernels of a dive in advance, in parallel processes.

One process compiles some hundreds of kernels for a dive one by one, which takes a minute. Here each
part of a tick runs once in its own process, in an almost empty sea. The compiled kernels are cached
on disk, where the dive finds them.
"""

import gc
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from queue import Empty, SimpleQueue

import numba
import numpy as np
from msgspec.structs import replace

from subsea.base.disk_cache import cache_folder
from subsea.base.files import make_own_folder
from subsea.base.language import marked
from subsea.base.source_stamp import ROOT, source_stamp
from subsea.base.system import cores
from subsea.behavior.table import run_routine
from subsea.frame.packet import pack
from subsea.geometry.solids import height_at
from subsea.habitat.stone import SUN
from subsea.jobs.background import CancelledByUserError
from subsea.perception.focusser import focus
from subsea.scenario.load import load_scenario
from subsea.sound.mixer import Mixer, SoundLevels
from subsea.sound.moment import Sources, hear
from subsea.sound.space import LAYOUTS, listener_of
from subsea.state import Clock, Reef, empty
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import cockpit, views_for
from subsea.world import step
from subsea.world.build import create_world
from subsea.world.world import TICK_S, World

CLOCK = Clock(0, 0, TICK_S)
MODULE = "subsea.dive.warm_up"  # run as a program by each process, with the name of a job
SCENARIO, FISHES = "peaceful", 12  # the world of the jobs
COMPILING = marked("compiling the fishes' code, once")
POLL_S = 0.1  # interval of checks for Ctrl-C and window events meanwhile
ROCK = np.array([[0.0, 0.0, 10.0, 30.0, 20.0, 20.0, 0.0]])


def _scenery() -> None:
    """Rocks, plants and the picture. The first half needs nothing that other jobs compile."""
    # Not above: what compiles without drawing imports no OpenGL.
    from subsea.rendering.fish.soft_shadows import COLUMNS as SHADOW_COLUMNS
    from subsea.rendering.fish.soft_shadows import Sand, cast
    from subsea.rendering.gl.static_batch import bounding_spheres, gather, levels_in_sight
    from subsea.rendering.reef.rocks import overgrown
    from subsea.rendering.reef.seaweed import FRONDS_AT, fronds_of
    from subsea.rendering.sea.ground_map import with_growths
    from subsea.rendering.sea.particles import in_sight
    from subsea.rendering.sea.seabed import surroundings

    sand, pillars = Sand(np.zeros((2, 2), np.float32), 100.0), np.zeros((0, 4))
    bare = empty(Reef, k=0)
    spheres = bounding_spheres(overgrown(*sand, pillars, ROCK, 12.0, bare))
    ground = surroundings(*sand, pillars, ROCK, 12.0, bare)
    with_growths(ground, np.array([[0.0, 0.0, 5.0, 5.0, 0.5]]), SUN)
    world = create_world(load_scenario(SCENARIO)[0], fish=FISHES)
    packet = pack(world, views_for("mono", (64, 64), cockpit(world.state.submarine, 1.0)), 1.0)
    spots = np.zeros((1, SHADOW_COLUMNS), np.float32)
    cast(packet.instances, np.ones(len(world.species)), sand, ROCK[0, :3], ROCK[0, :3], spots)
    before = np.zeros(len(spheres), np.int64)
    levels_in_sight(
        (spheres[:, :3].copy(), spheres[:, 3].copy()), packet.views, 1.0, 1.0, np.ones(2), before
    )
    gather(np.zeros((0, 3), np.int32), np.zeros((0, 3), np.int64))
    everything = np.ones((1, len(packet.leaves)), np.bool_)
    fronds_of(packet.leaves, everything, 0, len(packet.leaves), FRONDS_AT[0])
    (view,) = packet.views
    in_sight(np.zeros((0, 2, 3)), view.planes, np.asarray(view.eye, np.float64), 1.0)


def _decisions() -> None:
    world = _open_water()
    state, everyone = world.state, np.arange(len(world.state.fishes.species))
    step.decide(world, everyone, everyone, CLOCK)
    focus(everyone, state.fishes, state.minds, state.sea, world.nature, CLOCK)


def _routines() -> None:
    world, nobody = _open_water(), np.zeros(0, np.int64)
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    run_routine(np.int64(0), nobody, fishes, minds, sea, world.nature, CLOCK)
    step.act(world, nobody, np.arange(len(fishes.species)), NEUTRAL, CLOCK)


def _motion() -> None:
    world = _open_water()
    step.perceive(world, CLOCK, NEUTRAL)
    everyone = np.arange(len(world.state.fishes.species))
    step.move_water(world, everyone, CLOCK)
    step.move_fishes(world, everyone, CLOCK)


def _sound() -> None:
    world = _open_water()
    ears = listener_of(world)
    around = Sources(np.array([[*ears.place, 500.0]]), np.array([[*ears.place, 30.0, 1.0]]))
    mixer = Mixer(LAYOUTS["stereo"])
    for tick in range(1, 40):  # until shrimp snap
        world.state.tick = tick
        mixer.mix(hear(world, ears, around), SoundLevels())


def _open_water() -> World:
    """A world whose creation compiles little."""
    names = "rock", "outcrop", "ridge", "arch", "seaweed", "vent", "reef", "coral", "tour"
    bare = dict.fromkeys(names, ())
    return create_world(replace(load_scenario(SCENARIO)[0], **bare), fish=FISHES)


JOBS: dict[str, Callable[[], None]] = {
    "scenery": _scenery,
    "routines": _routines,
    "motion": _motion,
    "decisions": _decisions,
    "sound": _sound,
}
"""The parts of a dive, in the order of their start: the first picture, then the slowest."""
FIRST = "scenery"


def warm_up(
    tell: Callable[[str], None] = lambda message: None,
    check: Callable[[], None] = lambda: None,
    processes: int | None = None,
    first: Callable[[], None] = lambda: None,
) -> None:
    """Compile all kernels of a dive that are not cached yet, in parallel `processes`.

    None: one for each core. Does nothing with a single process, which would gain no time, or if
    nothing can be cached. `tell` gets lines on the progress; `check` is called meanwhile and may
    raise, which ends the processes; `first` is called once what draws a world is compiled.
    """
    marker = _marker()
    if marker.exists():
        return
    processes = cores() if processes is None else processes
    if processes > 1 and _can_write(marker.parent):
        with _one_at_a_time(tell, check), suppress(OSError):  # no more processes may be started
            if marker.exists() or _run_all(min(processes, len(JOBS)), tell, check, first):
                for old in marker.parent.glob("warm-*"):
                    old.unlink(missing_ok=True)
                marker.touch()
                return
    tell(marked("compiling the fishes' code (a minute or more)"))


class WarmUp:
    """Compile kernels in a thread, so that a world is seen before its fishes can move."""

    def __init__(self) -> None:
        """Start to compile."""
        self._lines: SimpleQueue[str] = SimpleQueue()
        self._fault: BaseException | None = None
        self._first, self._cancelled = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="warm-up", daemon=True)
        self._thread.start()

    def wait_for_first(self, tell: Callable[[str], None]) -> None:
        """Wait until a world can be created and drawn; `tell` gets lines on the progress."""
        self._wait(self._first.is_set, tell)

    def wait(self, tell: Callable[[str], None]) -> None:
        """Wait until a world can be stepped."""
        self._wait(lambda: not self._thread.is_alive(), tell)

    def cancel(self) -> None:
        """End the processes; what they have not compiled is compiled when it is called."""
        self._cancelled.set()

    def _wait(self, done: Callable[[], bool], tell: Callable[[str], None]) -> None:
        while not done() or not self._lines.empty():
            with suppress(Empty):
                tell(self._lines.get(timeout=POLL_S))
        if self._fault:
            raise self._fault

    def _run(self) -> None:
        try:
            warm_up(self._lines.put, self._check, first=self._first.set)
        except BaseException as fault:
            self._fault = fault
        self._first.set()

    def _check(self) -> None:
        if self._cancelled.is_set():
            raise CancelledByUserError


def _marker() -> Path:
    """The file beside cached kernels that marks those of the current code as complete."""
    code = f"{source_stamp(Path(__file__).resolve())[:32]}-{numba.__version__}"
    return Path(height_at.stats.cache_path or cache_folder()) / f"warm-{code}"


def _can_write(place: Path) -> bool:
    """True if compiled code can be cached in a folder."""
    probe = place / f".probe-{os.getpid()}"
    try:
        place.mkdir(parents=True, exist_ok=True)
        probe.write_bytes(b"1")
    except OSError:
        return False
    finally:
        with suppress(OSError):
            probe.unlink()
    return True


@contextmanager
def _one_at_a_time(tell: Callable[[str], None], check: Callable[[], None]) -> Iterator[None]:
    """Wait while another start compiles. Without file locks (Windows) both compile."""
    with ExitStack() as stack:
        with suppress(ImportError, OSError):
            from fcntl import LOCK_EX, LOCK_NB, flock

            place = cache_folder().parent
            make_own_folder(place)
            lock = os.open(place / "compiling", os.O_RDWR | os.O_CREAT | os.O_NONBLOCK)
            stack.callback(os.close, lock)
            told = False
            while not _locks(lambda: flock(lock, LOCK_EX | LOCK_NB)):
                if not told:
                    tell(marked("waiting for another dive, which compiles the fishes' code"))
                told = True
                check()
                time.sleep(POLL_S)
        yield


def _locks(lock: Callable[[], None]) -> bool:
    """True if `lock` could lock its file."""
    try:
        lock()
    except BlockingIOError:
        return False
    return True


def _run_all(
    processes: int,
    tell: Callable[[str], None],
    check: Callable[[], None],
    first: Callable[[], None],
) -> bool:
    """Run all jobs, some at a time; return whether all succeeded. An exception ends them."""
    waiting = list(JOBS)
    running: dict[subprocess.Popen[bytes], str] = {}
    done = 0
    with ExitStack() as stack:
        tell(f"{COMPILING}: 0/{len(JOBS)}")
        while waiting or running:
            while waiting and len(running) < processes:
                job = waiting.pop(0)
                running[_start(job, stack)] = job
            with suppress(subprocess.TimeoutExpired):
                next(iter(running)).wait(POLL_S)
            check()
            for worker in [worker for worker in running if worker.poll() is not None]:
                if worker.returncode:
                    return False
                if running.pop(worker) == FIRST:
                    first()
                done += 1
                tell(f"{COMPILING}: {done}/{len(JOBS)}")
    return True


def _start(job: str, stack: ExitStack) -> "subprocess.Popen[bytes]":
    """Start a job in a process that ends with the stack or with this process.

    -P: it imports nothing from the current folder.
    """
    paths = [str(ROOT), os.environ.get("PYTHONPATH", "")]
    worker = subprocess.Popen(
        [sys.executable, "-P", "-m", MODULE, job],
        stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))},
    )  # fmt: skip
    stack.enter_context(worker)
    stack.callback(worker.kill)
    return worker


def end_with_parent() -> None:
    """Ignore Ctrl-C, which the parent also gets, and end with the parent."""

    def wait() -> None:
        os.read(0, 1)  # not through sys.stdin, whose lock a thread may not hold at exit
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=wait, daemon=True).start()


if __name__ == "__main__":
    end_with_parent()
    gc.set_threshold(200_000, 20, 20)  # the compiler's many objects: a sixth of its time
    JOBS[sys.argv[1]]()
