"""Compile the kernels of a dive in advance, in parallel processes.

One process compiles some hundreds of kernels for a dive one by one, which takes a minute. Here the
parts of a tick run once, in an almost empty sea, in a process for each core. The compiled kernels
are cached on disk, where the dive finds them. A wheel ships them, and then nothing is left to do.
"""

import gc
import hashlib
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from subsea.base.disk_cache import cache_folder
from subsea.base.files import make_own_folder
from subsea.base.language import marked
from subsea.base.source_stamp import source_stamp
from subsea.base.system import cores
from subsea.behavior import grazing
from subsea.behavior.table import BEHAVIORS
from subsea.dive.camera_way import hidden
from subsea.frame.packet import pack
from subsea.geometry.solids import height_at
from subsea.habitat.odour import carry_odours, make_odour, release_catches
from subsea.habitat.stone import SUN
from subsea.kernels.cache import processor, shipped_code, versions
from subsea.perception.focusser import focus
from subsea.perception.sites import reefers_of, see_sites
from subsea.perception.smell import smell
from subsea.scenario.load import load_scenario
from subsea.sound.mixer import Mixer, SoundLevels
from subsea.sound.moment import Sources, hear
from subsea.sound.space import LAYOUTS, listener_of
from subsea.state import PREDATOR, Clock, Reef, empty
from subsea.submarine.vessel import NEUTRAL, hull_axes, keep_clear
from subsea.view.display_rigs import cockpit, views_for
from subsea.world import step
from subsea.world.build import create_world
from subsea.world.world import TICK_S, World

CLOCK = Clock(0, 0, TICK_S)
SCENARIO, FISHES = "peaceful", 12  # the world of the jobs
COMPILING = marked("compiling the fishes' code, once")
ROCK = np.array([[0.0, 0.0, 10.0, 30.0, 20.0, 20.0, 0.0]])


def _scenery() -> None:
    """Rocks, plants and the picture. The first half needs nothing that other jobs compile."""
    # Not above: what compiles without drawing imports no OpenGL.
    from subsea.rendering.fish.soft_shadows import COLUMNS as SHADOW_COLUMNS
    from subsea.rendering.fish.soft_shadows import Sand, cast
    from subsea.rendering.gl import item_levels
    from subsea.rendering.gl.static_batch import NO_BITES, bounding_spheres
    from subsea.rendering.reef.rocks import object_ids, overgrown
    from subsea.rendering.reef.seaweed import FRONDS_AT, fronds_of
    from subsea.rendering.sea.ground_map import with_growths
    from subsea.rendering.sea.particles import in_sight
    from subsea.rendering.sea.seabed import surroundings

    sand, pillars = Sand(np.zeros((2, 2), np.float32), 100.0), np.zeros((0, 4))
    bare = empty(Reef, k=0)
    spheres = bounding_spheres(overgrown(*sand, pillars, ROCK, 12.0, bare))
    object_ids(pillars, ROCK, ROCK[:, :3].copy())
    ground = surroundings(*sand, pillars, ROCK, 12.0, bare)
    with_growths(ground, np.array([[0.0, 0.0, 5.0, 5.0, 0.5]]), SUN)
    world = create_world(load_scenario(SCENARIO)[0], fish=FISHES)
    packet = pack(world, views_for("mono", (64, 64), cockpit(world.state.submarine, 1.0)), 1.0)
    spots = np.zeros((1, SHADOW_COLUMNS), np.float32)
    cast(packet.instances, np.ones(len(world.species)), sand, ROCK[0, :3], ROCK[0, :3], spots)
    centres, radii, state = (
        spheres[:, :3].copy(), spheres[:, 3].copy(), item_levels.empty_levels(len(spheres))
    )  # fmt: skip
    levels, seen = item_levels.levels_in_sight(
        (centres, radii), packet.views, 1.0, 1.0, np.ones(2), state.level
    )
    drawn = item_levels.Drawn(seen.copy(), seen[0].copy())
    shown, boxes = np.ones(len(levels), np.bool_), (centres, centres)
    item_levels.advance(levels, shown, seen, 0.0, boxes, NO_BITES, state, drawn)
    near = item_levels.nearness(centres, radii, centres, drawn.seen)
    ranges, absent = np.zeros((len(levels), 1, 3), np.int64), np.ones((len(levels), 1), np.bool_)
    item_levels.list_calls(np.argsort(near), state, drawn, ranges, absent)
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
    for behavior in BEHAVIORS:
        behavior.routine(nobody, fishes, minds, sea, world.nature, CLOCK)
    step.act(world, nobody, np.arange(len(fishes.species)), NEUTRAL, CLOCK)
    grazing.hold(fishes, minds, sea)  # this water has no stone to feed at
    grazing.bite(fishes, minds, sea, CLOCK)
    around = world.site_grids, reefers_of(fishes, minds)
    see_sites(nobody, fishes, minds, sea, world.nature, CLOCK, *around)


def _motion() -> None:
    world = _open_water()
    world.state.minds.kind[0] = PREDATOR  # which looks for prey
    everyone = np.arange(len(world.state.fishes.species))
    step.choose_turns(world, everyone, CLOCK, NEUTRAL)
    world.levels = True
    turn = step.choose_turns(world, everyone, CLOCK, NEUTRAL)
    step.perceive(world, everyone, CLOCK)
    step.move_water(world, everyone, CLOCK)
    odour = make_odour(world.state.sea)
    release_catches(odour, world.state.fishes.position[:1])
    carry_odours(odour, world.state.sea.radius, world.flow(), TICK_S)
    smell(everyone, world.state.fishes, world.state.minds, odour)
    step.move_fishes(world, everyone, turn.flapping, CLOCK)
    step.steer(world, world.state.submarine, NEUTRAL)
    keep_clear(np.zeros(3), np.zeros(3), world.state.sea)  # as a tour does
    hull_axes(*world.state.submarine.angles)
    hidden(world, (0.0, 0.0, -50.0), (1.0, 0.0, -50.0), 0.0)
    step.stay_in_free_water(world, turn, world.state.fishes.velocity.copy())


def _simulation() -> None:
    step.simulate(_open_water(live=1), CLOCK)


def _sound() -> None:
    world = _open_water()
    ears = listener_of(world)
    around = Sources(np.array([[*ears.place, 500.0]]), np.array([[*ears.place, 30.0, 1.0]]))
    mixer = Mixer(LAYOUTS["stereo"])
    for tick in range(1, 40):  # until shrimp snap
        world.state.tick = tick
        mixer.mix(hear(world, ears, around)._replace(room=1.0), SoundLevels(score=1.0))


def _open_water(live: int = 0) -> World:
    """A world whose creation compiles little."""
    names = "rock", "outcrop", "ridge", "arch", "wreck", "seaweed", "vent", "reef", "coral", "tour"
    bare = dict.fromkeys(names, ())
    return create_world(replace(load_scenario(SCENARIO)[0], **bare), fish=FISHES, live=live)


JOBS: dict[str, Callable[[], None]] = {
    "routines": _routines,
    "motion": _motion,
    "scenery": _scenery,
    "decisions": _decisions,
    "simulation": _simulation,
    "sound": _sound,
}
"""The parts of a dive, the slowest first."""


def warm_up(
    tell: Callable[[str], None] = lambda message: None, processes: int | None = None
) -> None:
    """Compile all kernels of a dive that are not shipped or cached yet, in parallel `processes`.

    None: one for each core. Does nothing with a single process, which would gain no time, or if
    nothing can be cached. `tell` gets lines on the progress.
    """
    marker = _marker()
    if marker.exists() or shipped_code() == code_stamp():
        return
    processes = cores() if processes is None else processes
    if processes > 1 and is_writable(marker.parent):
        with _one_at_a_time(tell), suppress(OSError):
            if marker.exists() or compile_all(processes, tell):
                return
    tell(marked("compiling the fishes' code (a minute or more)"))


def code_stamp() -> str:
    """Hash the sources of all kernels of a dive."""
    return source_stamp(Path(__file__).resolve())


def _marker() -> Path:
    """The file beside cached kernels that marks those of this code, Python and processor."""
    about = hashlib.sha256(repr((code_stamp(), versions(), processor())).encode()).hexdigest()
    folder = Path(height_at.stats.cache_path or cache_folder())
    return folder / f"warm-{versions()['python']}-{processor().cpu}-{about[:32]}"


def is_writable(folder: Path) -> bool:
    """True if a folder is there or can be made, and takes a file with content."""
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as probe:
            probe.write(b"1")
        return True
    return False


@contextmanager
def _one_at_a_time(tell: Callable[[str], None]) -> Iterator[None]:
    """Wait while another start compiles. Without file locks (Windows) both compile."""
    with ExitStack() as stack:
        with suppress(ImportError, OSError):
            from fcntl import LOCK_EX, LOCK_NB, flock

            folder = cache_folder().parent
            make_own_folder(folder)
            lock = stack.enter_context((folder / "compiling").open("a"))
            try:
                flock(lock, LOCK_EX | LOCK_NB)
            except BlockingIOError:
                tell(marked("waiting for another dive, which compiles the fishes' code"))
                flock(lock, LOCK_EX)
        yield


def compile_all(processes: int, tell: Callable[[str], None]) -> bool:
    """Run all jobs in processes that take one after another, and mark the kernels as compiled.

    Returns False if a job fails. An exception, such as Ctrl-C, ends the processes.
    """
    from subsea.jobs.workers import process_pool  # most starts compile nothing

    tell(f"{COMPILING}: 0/{len(JOBS)}")
    pool = process_pool(min(processes, len(JOBS)))
    try:
        for done, (_, good) in enumerate(
            pool(run_job, {job: job for job in JOBS}, lambda: None), 1
        ):
            if not good:  # its process crashed
                return False
            tell(f"{COMPILING}: {done}/{len(JOBS)}")
    except Exception:  # of a job: the dive compiles that part itself, and reports what is wrong
        return False
    marker = _marker()
    for old in marker.parent.glob(f"{marker.name.rpartition('-')[0]}-*"):
        old.unlink(missing_ok=True)
    marker.touch()
    return True


def run_job(job: str) -> bool:
    """Compile the kernels of a job."""
    gc.set_threshold(200_000, 20, 20)  # the compiler's many objects: a sixth of its time
    JOBS[job]()
    return True
