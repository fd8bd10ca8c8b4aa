"""`subsea soak`: hours of a dive with random input, checked for broken invariants."""

import ctypes
import gc
import json
import time
from collections.abc import Generator, Iterator, Sequence
from contextlib import closing
from itertools import count
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from subsea import __version__
from subsea.base import interrupts
from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.file_kinds import json_file
from subsea.base.files import check_file, replacing
from subsea.base.memory import resident_mb, trim
from subsea.base.progress import clock, count_noun, progress, say
from subsea.base.system import resource_names
from subsea.behavior.teleop import TeleopCommand
from subsea.dive.start import headless, picture_maker, start_world
from subsea.frame.packet import pack
from subsea.geometry.solids import height_at
from subsea.habitat.contact import clearances
from subsea.lab.benchmark_reports import read_json
from subsea.rendering.output.quality import PRESETS
from subsea.state import HUNGER, Sea
from subsea.submarine.vessel import AHEAD_CM_S, MAX_PITCH, NEUTRAL, Helm
from subsea.view.display_rigs import DISPLAYS, chosen_rig, cockpit, display_rig
from subsea.view.rig import CameraRig, views
from subsea.view.stereo import PAGED
from subsea.world import snapshot
from subsea.world.step import Order, step
from subsea.world.to_scenario import get_tunables, set_tunables
from subsea.world.world import TICK_S, World

SECOND = round(1.0 / TICK_S)  # ticks, about
MINUTE = round(60.0 / TICK_S)
SIZE = (320, 180)
SHRINK = 6  # of theatres
ROUNDS = 8  # of all displays and theatres in a soak, if it is long enough
PICTURES = 5, 30  # minimum and maximum in each of them, a second apart
REPLAY_EVERY, REPLAYED = MINUTE, 3 * SECOND  # interval between rewinds, and their length
SPELL_S = 0.5, 8.0  # duration of one kind of input
CURRENT_CM_S = 30.0
TIMIDITY = 0.5, 2.0
SHARES = {"steer": 0.6, "let go": 0.1, "ride": 0.2, "change": 0.1}
STILL = 180 * SECOND  # a fish that stays in place for this long is stuck
# While a soak draws, memory grows for this long, as the driver compiles programs for every display
# at every quality; it is judged if the same time follows.
WARM_UP_MIN = 24
QUARTER = 0.25  # the last quarter is compared with the second
MAX_GROWTH = 0.02
MAX_FAULTS = 10  # then the dive ends
REPORT = json_file("a report of `subsea soak`", "checksums")

# Limits of a sound world.
MAX_DEPTH_BL = 0.25  # of a fish's middle inside rock, body lengths
MAX_BL_S, MAX_DRIFT_CM_S = 12.0, 150.0  # speed of a fish: body lengths, and carried by water
OFF_UNIT = 1e-3  # tolerance of the length of a quaternion
STILL_BL = 0.5  # a fish that stays in a box of this size, in body lengths, does not move
IN_UNIT = (
    "fishes.weight", "fishes.gape", "minds.mental", "minds.light",
    "minds.menace", "minds.menaces",
)  # fmt: skip
QUATERNIONS = ("fishes.orientation", "fishes.previous_orientation")
SLACK = 1e-5  # for rounding


class RandomInput(NamedTuple):
    """Input of a visitor in a tick."""

    order: Order
    lights: bool
    current_cm_s: tuple[float, float]
    timidity: float


class _Report(msgspec.Struct):
    """The parts of an older report that are compared."""

    scenario: str
    set: list[str]
    seed: int
    fish: int
    version: str
    ticks: int
    checksums: list[str]


class Observations(NamedTuple):
    """Observations so far."""

    checksums: list[str]  # after every simulated minute
    memory_mb: list[float]  # then; empty if the system gives no figure
    things: list[int]  # then: objects of the garbage collector
    alive: list[int]  # then: fishes
    starving: list[int]  # then: fishes of maximum hunger
    objects: list[dict[str, int]]  # of OpenGL, after every round of displays
    replays: list[int]  # ticks at which a rewound past had been repeated
    faults: list[str]


def soak(
    scenario: str,
    minutes: float,
    fish: int | None,
    seed: int | None,
    draw: bool,
    out: Path | None,
    against: Path | None,
    changes: Sequence[str] = (),
) -> int:
    """Dive for `minutes` of simulated time with random input, and print the observations.

    Faults are impossible numbers and places, stuck fishes, a rewound past that repeats differently,
    changed constants, growth of memory and objects, empty pictures, and checksums that differ from
    those of the same dive in the report `against`. With `draw` a picture is drawn every second, in
    one display mode or theatre after another and at every quality. The report goes to `out` as
    JSON.

    Returns 0 without faults, else 1. The same arguments give the same dive.
    """
    if out is not None:
        check_file(out)
    older = None
    if against is not None:
        decoder = msgspec.json.Decoder(_Report)
        older = read_json(against, "subsea soak", decoder.decode)
    world = start_world(scenario, seed, fish, changes=changes)
    watch = Observations(*([] for _ in Observations._fields))
    ticks = max(round(minutes * MINUTE), 1)
    about = {
        "scenario": scenario,
        "set": [*changes],
        "seed": world.state.seed,
        "fish": len(world.state.fishes.species),
        "version": __version__,
    }
    if older is not None:
        for name, value in about.items():
            if (theirs := getattr(older, name)) != value:
                raise UserError(f"{against}: a soak with {name} {theirs!r}, expected {value!r}")
    begun, first = time.monotonic(), world.state.tick

    def conclude() -> None:
        """Judge the observations, write and print them, also after an interruption."""
        made = world.state.tick - first
        if older is not None:
            _compare(watch, made, older)
        judge(watch, draw)
        if out is not None:
            report = about | {"drawn": draw, "ticks": made, **watch._asdict()}
            with replacing(out) as temporary:
                temporary.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
        _tell(world, watch, draw, time.monotonic() - begun)

    try:
        if draw:
            with headless() as context, closing(_draw_all(world, context, watch, ticks)) as drawing:
                _dive(world, ticks, watch, drawing)
        else:
            _dive(world, ticks, watch)
    except KeyboardInterrupt:
        conclude()
        raise
    conclude()
    return 1 if watch.faults else 0


def _dive(
    world: World,
    ticks: int,
    watch: Observations,
    drawing: Generator[None, None, None] | None = None,
) -> None:
    """Make the ticks and note what is seen."""

    def fault(what: str) -> None:
        watch.faults.append(f"tick {world.state.tick}: {what}")

    inputs = random_input(world, np.random.default_rng(world.state.seed))
    done: list[RandomInput] = []  # since the snapshot to which time is rewound
    before, boxes = None, visited_now(world)
    fixed = snapshot.checksum_of(snapshot.constant(world))
    with interrupts.deferred_interrupts() as check, progress(ticks, "tick") as made:
        for k in range(1, ticks + 1):
            check()
            if k % REPLAY_EVERY == REPLAY_EVERY - REPLAYED:
                before, done = (snapshot.take(world), get_tunables(world)), []
            done.append(next(inputs))
            act(world, done[-1])
            if before and k % REPLAY_EVERY == 0:
                after = snapshot.checksum(world)
                set_tunables(world, before[1])
                snapshot.restore(world, before[0])
                for given in done:
                    act(world, given)
                if snapshot.checksum(world) != after:
                    fault("a rewound past repeated differently")
                watch.replays.append(world.state.tick)
                before = None
            if k % SECOND == 0:
                widen(boxes, world)
                for what in faults_in(world):
                    fault(what)
                if k % STILL == 0:
                    for i in stuck(boxes, world):
                        fault(f"fish {i} is stuck")
                    boxes = visited_now(world)
                if drawing:
                    next(drawing)
            if k % MINUTE == 0 or k == ticks:
                if snapshot.checksum_of(snapshot.constant(world)) != fixed:
                    fault("a constant of the world has changed")
                watch.checksums.append(snapshot.checksum(world))
                trim()  # free memory is up to half of a dive with drawing
                watch.memory_mb.extend(resident_mb())
                watch.things.append(len(gc.get_objects()))
                watch.alive.append(int(world.state.fishes.alive.sum()))
                watch.starving.append(starving(world))
            made()
            if len(watch.faults) >= MAX_FAULTS:
                break


def random_input(world: World, rng: np.random.Generator) -> Iterator[RandomInput]:
    """Yield random input for each tick: steering, letting go, riding a fish, changes."""
    current, timidity, lights = world.current_cm_s, world.nature.timidity, False
    while True:
        order: Order = NEUTRAL
        what = rng.choice(list(SHARES), p=list(SHARES.values()))
        ask = rng.uniform(-1.0, 1.0, 4)
        ticks = round(rng.uniform(*SPELL_S) / TICK_S)
        living = np.flatnonzero(world.state.fishes.alive)
        if what == "steer":
            order = Helm(*ask.tolist())
        elif what == "ride" and len(living):
            order = TeleopCommand(int(rng.choice(living)), *ask[:3].tolist())
        elif what == "change":
            current = float(CURRENT_CM_S * ask[0]), float(CURRENT_CM_S * ask[1])
            timidity, lights = float(rng.uniform(*TIMIDITY)), not lights
        for _ in range(ticks):
            yield RandomInput(order, lights, current, timidity)


def act(world: World, given: RandomInput) -> None:
    """Make one tick of the world with this input."""
    world.state.submarine.lights[0] = given.lights
    world.current_cm_s = given.current_cm_s
    world.nature = world.nature._replace(timidity=given.timidity)
    step(world, given.order)


def rigs() -> list[CameraRig]:
    """Make rigs of every display mode without a special window, and of every theatre, shrunk."""
    theatres = resource_names("assets/theatres", ".toml")
    return [
        *(display_rig(display, SIZE) for display in DISPLAYS if display != PAGED),
        *(chosen_rig("mono", SIZE, theatre=name, shrink=SHRINK)[0] for name in theatres),
    ]


def _draw_all(
    world: World, context: Any, watch: Observations, ticks: int
) -> Generator[None, None, None]:
    """Draw a picture at every `next`, cycling through rigs and qualities."""
    shown = rigs()
    pictures = int(np.clip(ticks // (SECOND * ROUNDS * len(shown)), *PICTURES))
    for number in count():
        rig = shown[number % len(shown)]
        quality = list(PRESETS.values())[(number + number // len(shown)) % len(PRESETS)]
        with picture_maker(context, world, rig, quality) as renderer:
            for _ in range(pictures):
                seen = views(rig, cockpit(world.state.submarine, 1.0))
                renderer.draw(pack(world, seen, 1.0, options=quality.packing))
                for output in range(len(rig.outputs)):
                    if np.ptp(renderer.read_pixels(output)) == 0:
                        watch.faults.append(f"tick {world.state.tick}: an empty picture")
                yield
        if rig is shown[-1]:
            watch.objects.append(_count_objects(context))


def _count_objects(context: Any) -> dict[str, int]:
    """Count the OpenGL objects of each kind in a context."""
    from subsea.rendering.gl.context import gl_function

    made = {
        "Buffer": context.buffer(reserve=4),
        "Texture": context.texture((1, 1), 1),
        "Renderbuffer": context.renderbuffer((1, 1)),
        "Program": context.program(
            vertex_shader="#version 330\nvoid main() { gl_Position = vec4(0.0); }"
        ),
    }
    counts = {}
    for kind, last in made.items():
        exists = gl_function(context, f"glIs{kind}", ctypes.c_uint, result=ctypes.c_ubyte)
        counts[kind] = sum(bool(exists(name)) for name in range(1, last.glo))
        last.release()
    return counts


def _compare(watch: Observations, ticks: int, older: _Report) -> None:
    """Add a fault for each common minute, and a common end, with different checksums."""
    both = min(ticks, older.ticks) // MINUTE
    pairs = list(zip(watch.checksums, older.checksums, strict=False))
    for k, (mine, theirs) in enumerate(pairs if ticks == older.ticks else pairs[:both]):
        if mine != theirs:
            watch.faults.append(f"minute {k + 1}: checksum differs from the older soak")


def judge(watch: Observations, drawn: bool) -> None:
    """Add faults for growth; memory of a dive with drawing counts after its warm-up."""
    if grown := growth(steady(watch, drawn)):
        watch.faults.append(f"memory grew by {grown:.1%}")
    if grown := growth(watch.things):
        watch.faults.append(f"Python objects grew by {grown:.1%}")
    for kind in watch.objects[0] if watch.objects else ():
        numbers = [objects[kind] for objects in watch.objects]
        if numbers[-1] > numbers[0]:
            watch.faults.append(f"OpenGL objects not released: {kind}, {numbers}")


def steady(watch: Observations, drawn: bool) -> list[float]:
    """Take memory after the warm-up; empty if the dive is too short to judge it."""
    if not drawn:
        return watch.memory_mb
    return watch.memory_mb[WARM_UP_MIN:] if len(watch.memory_mb) >= 2 * WARM_UP_MIN else []


def growth(values: Sequence[float]) -> float:
    """Compute the relative growth of values, one a minute; 0 if it is acceptable.

    Compares the medians of the last and the second quarter: single minutes differ by a tenth with
    the display and the quality that are drawn.
    """
    quarter = round(QUARTER * len(values))
    if quarter < 1:
        return 0.0
    grown = median(values[-quarter:]) / median(values[quarter : 2 * quarter]) - 1.0
    return grown if grown > MAX_GROWTH else 0.0


def _tell(world: World, watch: Observations, drawn: bool, seconds: float) -> None:
    number = len(world.state.fishes.species)
    fishes = count_noun(number, "fish", "fishes")
    print(f"{clock(world.state.tick * TICK_S)} simulated, {fishes}, in {clock(seconds)}")
    if watch.checksums:
        print(f"checksum at the end: {watch.checksums[-1]}")
        print(f"alive at the end: {watch.alive[-1]} of {number}, {watch.starving[-1]} starving")
    print(f"time was rewound {count_noun(len(watch.replays), 'time', 'times')}")
    if watch.memory_mb:
        first, last = watch.memory_mb[len(watch.memory_mb) // 4], watch.memory_mb[-1]
        judged = "" if steady(watch, drawn) else ", too short to judge it"
        print(f"memory: {first:.1f} MB after a quarter, {last:.1f} at the end{judged}")
    if watch.things:
        first, last = watch.things[len(watch.things) // 4], watch.things[-1]
        print(f"Python objects: {first} after a quarter, {last} at the end")
    if watch.objects:
        for when, objects in (("first", watch.objects[0]), ("last", watch.objects[-1])):
            kinds = ", ".join(f"{kind} {number}" for kind, number in objects.items())
            print(f"OpenGL objects after the {when} round of displays: {kinds}")
    for fault in watch.faults:
        say(fault)
    print(count_noun(len(watch.faults), "fault", "faults") if watch.faults else "sound")


def faults_in(world: World) -> list[str]:
    """List the faults of a world: impossible values, bodies in impossible places."""
    try:
        snapshot.check(world)
    except UserError as fault:
        return [str(fault)]
    return [*_odd_numbers(world), *_misplaced(world), *_too_fast(world)]


def _odd_numbers(world: World) -> Iterator[str]:
    """List shares outside 0 to 1, and quaternions that are not of unit length."""
    arrays = snapshot.changing(world)
    for name in IN_UNIT:
        for where in np.argwhere((arrays[name] < -SLACK) | (arrays[name] > 1.0 + SLACK))[:1]:
            k = tuple(int(index) for index in where)
            yield f"{name}{[*k]} is {arrays[name][k]:g}, expected a share"
    for k in np.flatnonzero(np.abs(arrays["fishes.display"]) > 1.0 + SLACK)[:1]:
        yield f"fishes.display[{k}] is {arrays['fishes.display'][k]:g}, expected -1 to 1"
    for name in QUATERNIONS:
        length = np.linalg.norm(arrays[name], axis=1)
        for k in np.flatnonzero(np.abs(length - 1.0) > OFF_UNIT)[:1]:
            yield f"{name}[{k}] is a quaternion of length {length[k]:g}"


def _misplaced(world: World) -> Iterator[str]:
    """List fishes, the submarine and plankton outside the sea or inside rock."""
    sea, fishes, submarine = world.state.sea, world.state.fishes, world.state.submarine
    swims = in_water(world)
    names = [*(f"fish {i}" for i in swims), "the submarine"]
    places = np.concatenate([fishes.position[swims], submarine.position[None]])
    # Those that feed on drawn stone may be in the shell around it.
    allowed = np.append(MAX_DEPTH_BL * fishes.length[swims] + fishes.shell[swims], 0.0)
    out, deep = out_of_sea(places, sea), depth_in_rock(places, sea)
    for k in np.flatnonzero(out):
        yield f"{names[k]} is out of the sea, at {_words(places[k])}"
    for k in np.flatnonzero(deep > allowed):
        yield f"{names[k]} is {deep[k]:.0f} cm inside rock, at {_words(places[k])}"
    there = sea.plankton[sea.absent <= 0.0]
    for k in np.flatnonzero(out_of_sea(there, sea))[:1]:
        yield f"a speck of plankton is out of the sea, at {_words(there[k])}"


def _too_fast(world: World) -> Iterator[str]:
    """List speeds beyond those of muscles and propeller."""
    fishes, submarine = world.state.fishes, world.state.submarine
    swims = in_water(world)
    way = fishes.position[swims] - fishes.previous_position[swims]
    speed = np.linalg.norm(way, axis=1) / TICK_S
    for k in np.flatnonzero(speed > MAX_BL_S * fishes.length[swims] + MAX_DRIFT_CM_S):
        yield f"fish {swims[k]} moves at {speed[k]:.0f} cm/s"
    if (speed := float(np.linalg.norm(submarine.velocity))) > 2.0 * AHEAD_CM_S:
        yield f"the submarine moves at {speed:.0f} cm/s"
    if abs(submarine.angles[1]) > MAX_PITCH + SLACK:
        yield f"the submarine's pitch is {np.degrees(submarine.angles[1]):.0f} degrees"


def in_water(world: World) -> NDArray[np.intp]:
    """Find the living fishes, except one that a hook pulls out of the water."""
    swims = world.state.fishes.alive.copy()
    if (caught := int(world.state.sea.catch[1])) >= 0:
        swims[caught] = False
    return np.flatnonzero(swims)


def starving(world: World) -> int:
    """Count living fishes of maximum hunger."""
    return int((world.state.fishes.alive & (world.state.minds.mental[:, HUNGER] >= 1.0)).sum())


def out_of_sea(places: Array, sea: Sea) -> NDArray[np.bool_]:
    """Flag places (n, 3) beyond the bounds, in the air or in the ground."""
    floor = [height_at(sea.heights, sea.half_width, float(x), float(y)) for x, y, _ in places]
    beyond = np.hypot(places[:, 0], places[:, 1]) > sea.radius * (1.0 + SLACK)
    return np.asarray(beyond | (places[:, 2] <= floor) | (places[:, 2] >= 0.0))


def depth_in_rock(places: Array, sea: Sea) -> Array:
    """Measure the depth of places (n, 3) inside pillars and rocks (n,), cm; 0 outside."""
    return np.maximum(-clearances(sea.pillars, sea.rocks, places), 0.0)


class VisitedBoxes(NamedTuple):
    """The bounding box of each fish's positions."""

    low: Array  # (n, 3), cm
    high: Array  # (n, 3), cm


def visited_now(world: World) -> VisitedBoxes:
    """Make boxes of the current positions only."""
    return VisitedBoxes(world.state.fishes.position.copy(), world.state.fishes.position.copy())


def widen(boxes: VisitedBoxes, world: World) -> None:
    """Extend the boxes to the current positions."""
    np.minimum(boxes.low, world.state.fishes.position, out=boxes.low)
    np.maximum(boxes.high, world.state.fishes.position, out=boxes.high)


def stuck(boxes: VisitedBoxes, world: World) -> list[int]:
    """Find the living fishes that have not moved."""
    side = np.linalg.norm(boxes.high - boxes.low, axis=1)
    swims = in_water(world)
    return [int(i) for i in swims if side[i] < STILL_BL * world.state.fishes.length[i]]


def _words(place: Array) -> str:
    return ", ".join(f"{x:.0f}" for x in place)
