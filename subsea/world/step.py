"""Advance a world by one tick.

A pass of the tick is one compiled kernel, called for parts of the fishes. Threads take turns to
hold the interpreter's lock between two kernels, so fewer kernels mean fewer turns.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.behavior import biting, eating, grazing, hunting, schooling, steering
from subsea.behavior.chasing import tire
from subsea.behavior.courtship import ease_display
from subsea.behavior.inspecting import advance_inspections
from subsea.behavior.intention import choose_intention
from subsea.behavior.mating import end_courtships
from subsea.behavior.mental_state import update_mental_state
from subsea.behavior.moods import update_moods
from subsea.behavior.steering import ease_goals
from subsea.behavior.table import compute_desires, run_routines
from subsea.behavior.teleop import TeleopCommand, TeleopCommands, as_commands, follow_commands
from subsea.directing.director import cue, direct
from subsea.directing.script import DirectingContext
from subsea.habitat import plankton
from subsea.habitat.contact import keep_in_free_water, separate
from subsea.habitat.current import add_bow_wave, set_drift, shear_at
from subsea.habitat.day import in_daylight, move_sky
from subsea.habitat.odour import STEP_TICKS, carry_odours, release_bait, release_catches
from subsea.habitat.rocks import RockCells
from subsea.habitat.sea import move_hook
from subsea.habitat.seaweed import step_seaweed
from subsea.habitat.sites import regrow
from subsea.kernels import kernel
from subsea.kernels.threads import cut, run_all, share
from subsea.motor.containment import contain
from subsea.motor.controller import command
from subsea.motor.fins import flap_in_turn
from subsea.motor.playback import play
from subsea.motor.switching import LiveWater, swim
from subsea.perception.focusser import focus
from subsea.perception.senses import fish_due, sense
from subsea.perception.sites import reefers_of, see_sites
from subsea.perception.smell import smell
from subsea.repertoire.library import Library
from subsea.state import Clock, Fishes, Minds, Sea, State, Submarine
from subsea.submarine.vessel import STATION, Helm, Rail, hull_axes, ride, step_hull
from subsea.world.levels import Turns, find_turns
from subsea.world.periodic import wrap
from subsea.world.shell import keep_off_drawn
from subsea.world.world import TICK_S, World


@kernel
def carry(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, cells: RockCells, flow: Array) -> None:
    """Set the drift of the fishes `who` by the current `flow` (3,), cm/s, the hull and others."""
    set_drift(who, fishes, sea, cells, flow)
    add_bow_wave(who, fishes, sea)
    separate(who, fishes, minds)


@kernel
def ease(who: Ints, fishes: Fishes, minds: Minds, clock: Clock) -> None:
    """Turn the goals of the fishes `who` toward their urges, and let bursts tire them."""
    ease_goals(who, fishes, minds, clock)
    tire(who, fishes, minds, clock)


@kernel
def play_back(
    who: Ints, fishes: Fishes, library: Library, sea: Sea, flapping: Bools, dt: float
) -> None:
    """Advance bodies of the fishes `who` by one tick, within the free water, and fins in turn."""
    play(who, fishes, library, dt)
    contain(who, fishes, library.nodes, sea, dt)
    keep_off_drawn(who, fishes, library.nodes, sea, dt)
    flap_in_turn(who, fishes, library, flapping, dt)


# Fishes for which another thread pays: in a short pass, and in a pass over thinking fishes.
LEAST_PART, LEAST_MINDS = 2048, 1024
LEAST_SPECKS, LEAST_CLUSTERS = 512, 12  # of plankton and of seaweed

# Input that steers the submarine or fishes in a tick.
Order = Helm | Rail | TeleopCommand | TeleopCommands


def step(world: World, order: Order) -> None:
    """Advance the world by one tick, 33 ms.

    A helm or a rail moves the submarine. With teleop commands the submarine holds its place, and
    each command steers a fish in place of its intentions. Raises an IndexError for an unknown fish.
    """
    state = world.state
    clock = Clock(state.seed, state.tick, TICK_S)
    commands = as_commands(order) if isinstance(order, TeleopCommand) else order
    world.stages_s.clear()
    world.order = commands
    everyone = np.arange(len(state.fishes.species))
    with _stage(world, "behavior"):
        direct(world.script, state, world.nature, world.current_cm_s, clock)
    swimming = state.fishes.velocity - state.fishes.drift
    with _stage(world, "perception"):
        place_hull(state)
        turn = choose_turns(world, everyone, clock, commands)
    with _stage(world, "habitat"):
        move_water(world, turn.feeling, clock)
    with _stage(world, "perception"):
        who = turn.thinking
        perceive(world, who, clock)
    free = who
    if isinstance(commands, TeleopCommands):
        free = np.setdiff1d(who, commands.fish, assume_unique=True)
    with _stage(world, "behavior"):
        decide(world, who, free, clock)
    with _stage(world, "perception"):
        nature = in_daylight(world.nature, state.sea.sky[1])
        focus(free, state.fishes, state.minds, state.sea, nature, clock)
    with _stage(world, "behavior"):
        act(world, free, everyone, commands, clock)
        state.minds.pause[who] = 0.0
    with _stage(world, "habitat"):
        stay_in_free_water(world, turn, swimming)
    with _stage(world, "motor"):
        move_fishes(world, everyone, turn.flapping, clock)
    if isinstance(order, Rail):
        ride(state.submarine, order, TICK_S)
    else:
        steer(world, state.submarine, order if isinstance(order, Helm) else STATION)
    state.tick += 1
    for observe in world.observers:
        observe(world)


def cue_direction(world: World, k: int) -> None:
    """Start a direction of the scenario between two ticks, whatever its conditions."""
    state = world.state
    clock = Clock(state.seed, state.tick, TICK_S)
    cue(DirectingContext(world.script, state, world.nature, world.current_cm_s, clock), k)


def place_hull(state: State) -> None:
    """Let the fishes know where the submarine is."""
    hull, submarine = state.sea.submarine, state.submarine
    hull[:3], hull[3:6] = submarine.position, submarine.velocity
    hull[6:] = hull_axes(*submarine.angles)[0]


def move_water(world: World, who: Ints, clock: Clock) -> None:
    """Move the sky, current, plankton, seaweed and hook, and carry the fishes `who`.

    The others drift on as before.
    """
    state, sea, fishes = world.state, world.state.sea, world.state.fishes
    flow = world.flow()
    water, cells = world.scenario.water, world.rock_cells
    move_sky(sea, water.hour, water.day_minutes, clock)
    specks, clusters = np.arange(len(sea.plankton)), np.arange(len(sea.seaweed))
    seaweed = state.seaweed, fishes, sea, cells, flow, water.visibility_cm, clock
    tasks = [
        *cut(plankton.drift, specks, LEAST_SPECKS, sea, cells, flow, clock),
        *cut(step_seaweed, clusters, LEAST_CLUSTERS, *seaweed),
        *cut(carry, who, LEAST_PART, fishes, state.minds, sea, cells, flow),
    ]
    run_all(tasks, shared=len(tasks) > 3)  # any of the three is worth two threads
    move_hook(sea, clock)
    regrow(sea, clock.dt)
    if clock.tick % STEP_TICKS == 0:
        carry_odours(state.odour, sea.radius, flow, STEP_TICKS * clock.dt)
        release_bait(state.odour, sea, STEP_TICKS * clock.dt)


def choose_turns(world: World, everyone: Ints, clock: Clock, order: Order) -> Turns:
    """Choose the fishes that think, that feel the water and whose fins move in this tick.

    Fishes take turns to think: fishes far from the submarine do it less often. All feel the water
    and move their fins in every tick, unless the world has levels. Steered fishes that feed think
    in every tick, or they would miss what is before their mouths.
    """
    state, visibility = world.state, world.scenario.water.visibility_cm
    fishes, minds, sea = state.fishes, state.minds, state.sea
    steered = order.fish if isinstance(order, TeleopCommands) else everyone[:0]
    if world.levels:
        cues = [world.script.cues[k].who for k in np.flatnonzero(state.directions.running)]
        awake = np.concatenate([steered, *cues])
        turn = find_turns(state, visibility, world.nature.alarmed, awake, clock)
    else:
        due = fish_due(fishes, minds, sea, visibility, clock)
        flapping = np.ones(len(everyone), np.bool_)
        turn = Turns(due, everyone, ((clock, everyone),), flapping)
    if isinstance(order, TeleopCommands):
        feeding = steered[order.feeds]
        feeding = feeding[fishes.alive[feeding]]
        turn = turn._replace(thinking=np.union1d(turn.thinking, feeding))
    return turn


def perceive(world: World, who: Ints, clock: Clock) -> None:
    """Update the senses of the fishes `who`."""
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    nature = in_daylight(world.nature, sea.sky[1])
    sense(who, fishes, minds, sea, nature, clock)
    if world.state.odour.total.any() or minds.scent[who].any():
        share(smell, who, LEAST_MINDS, fishes, minds, world.state.odour)
    if len(sea.stock):
        lives = who[(minds.diet[who] | minds.ways[who]) > 0]
        around = world.site_grids, reefers_of(fishes, minds)
        share(see_sites, lives, LEAST_MINDS, fishes, minds, sea, nature, clock, *around)
    for perceive_more in world.senses:
        perceive_more(who, fishes, minds, sea, nature, clock)
    for fish, light in world.seen_light.items():
        minds.light[fish] = light


def decide(world: World, who: Ints, free: Ints, clock: Clock) -> None:
    """Update the mental states of the fishes `who`, and the intentions of those that are `free`."""
    fishes, minds, sea, nature = (
        world.state.fishes, world.state.minds, world.state.sea, world.nature
    )  # fmt: skip
    schooling.join_schools(who, fishes.alive, minds)
    schooling.guide_schools(fishes, minds, sea, clock)
    end_courtships(who, fishes, minds)

    hunting.advance_hunts(who, fishes, minds, clock)
    share(update_mental_state, who, LEAST_MINDS, fishes, minds, sea, nature, clock)
    share(update_moods, who, LEAST_MINDS, fishes, minds, nature, clock)
    share(advance_inspections, who, LEAST_MINDS, fishes, minds, nature, clock)
    table = world.table
    share(compute_desires, who, LEAST_MINDS, fishes, minds, sea, nature, clock, table.shared)
    compute_desires(who, fishes, minds, sea, nature, clock, table.whole)
    levels = table.level, table.behavior, table.tires
    share(choose_intention, free, LEAST_MINDS, minds, nature, *levels)


def act(world: World, free: Ints, everyone: Ints, order: Order, clock: Clock) -> None:
    """Turn the intentions of the fishes `free` into goals; update eating, biting and colours."""
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    fishes.gape[free] = 0.0
    fishes.close[free] = False
    run_routines(free, fishes, minds, sea, world.nature, clock, world.table)
    share(steering.keep_clear, free, LEAST_MINDS, fishes, minds, sea)
    if isinstance(order, TeleopCommands):
        living = order.taken(fishes.alive[order.fish])
        follow_commands(living, fishes, minds, sea, clock)

    share(ease, everyone, LEAST_PART, fishes, minds, clock)
    eating.ingest(fishes, minds, sea, clock)
    before = fishes.alive.copy()
    hunting.inhale(fishes, minds, sea, clock)
    release_catches(world.state.odour, fishes.position[before & ~fishes.alive])
    biting.bite(fishes, minds, sea, clock)
    if len(sea.stock):
        grazing.hold(fishes, minds, sea)
        grazing.bite(fishes, minds, sea, clock)
    share(ease_display, everyone, 4 * LEAST_PART, fishes, minds, sea, clock)


def stay_in_free_water(world: World, turn: Turns, swimming: Array) -> None:
    """Keep bodies with the velocities `swimming` (n, 3), cm/s, off solids and within the sea."""
    fishes, sea = world.state.fishes, world.state.sea
    for lasting, who in turn.parts:
        share(keep_in_free_water, who, LEAST_PART, fishes, sea, swimming, lasting.dt)


def move_fishes(world: World, everyone: Ints, flapping: Bools, clock: Clock) -> None:
    """Move every fish by one recorded frame, or by six steps of simulation.

    The fins of fishes that are not `flapping` (n,) rest.
    """
    state, fishes = world.state, world.state.fishes
    share(command, everyone, LEAST_PART, fishes, world.library, clock)
    if len(state.live.fish):
        simulate(world, clock)
    groups = fishes, world.library, state.sea, flapping
    share(play_back, everyone, LEAST_PART, *groups, TICK_S)
    wrap(fishes, state.minds)


def simulate(world: World, clock: Clock) -> None:
    """Move the fishes that are simulated, in the water around them, and report what explodes."""
    state, fishes = world.state, world.state.fishes
    shear = shear_at(state.live.fish, fishes, state.sea, world.rock_cells, world.flow())
    around = LiveWater(state.submarine.position, state.sea, shear)
    burst = swim(
        fishes, world.library, world.dynamics, state.live, around, clock, world.physics
    )  # fmt: skip
    world.report_bursts(burst)


def steer(world: World, submarine: Submarine, helm: Helm) -> None:
    """Advance a submarine in the sea of a world by one tick, in place."""
    step_hull(submarine, helm, TICK_S, world.state.sea)


@contextmanager
def _stage(world: World, name: str) -> Iterator[None]:
    """Measure the wall-clock time of one stage of the tick; parts of a stage add up."""
    start = time.perf_counter()
    yield
    spent = time.perf_counter() - start
    world.stages_s[name] = world.stages_s.get(name, 0.0) + spent
