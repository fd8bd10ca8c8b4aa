"""Pack a world and views into a packet, the only input of rendering."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.fish.skinning import Coupling, place
from subsea.fish.species import Species
from subsea.frame.diagrams import NO_LINES, Lines
from subsea.frame.in_sight import (
    LEAF_TEXELS,
    LeafLimits,
    leaf_texels,
    leaves_in_sight,
    plankton_in_sight,
)
from subsea.habitat.day import hour_at
from subsea.kernels import kernel
from subsea.kernels.threads import share
from subsea.motor.fins import fins_at
from subsea.motor.pose import pose_at
from subsea.repertoire.library import Library
from subsea.scenario.schema import UNGRADED, Grade, Water
from subsea.state import (
    FINS_AT_EASE,
    HANGING,
    HOOKED,
    LANDED,
    SINKING,
    STOWED,
    Fishes,
    Reef,
    Sea,
    empty,
)
from subsea.view.camera import View
from subsea.view.culling import IN_SIGHT, OUT_OF_SIGHT, ViewArrays, coverage, view_arrays
from subsea.view.display_rigs import cockpit
from subsea.view.levels import (
    LEVELS,
    SPECK,
    LodState,
    draw_order,
    empty_lod_state,
    thresholds_of,
    update_levels,
)
from subsea.view.rig import CameraPose
from subsea.world.world import TICK_S, World

# Columns of an instance: 30 float32, 120 bytes, eight attributes in the shader.
POSITION = slice(0, 3)  # cm, world
SCALE = 3  # length of the fish over that of the recorded one (α of SMC eq. 12)
ORIENTATION = slice(4, 8)  # w, x, y, z, body to world
ROW_A, ROW_B, WEIGHT = 8, 9, 10  # two rows of the control-point table, and the weight of b
IDENTITY = 11  # in [0, 1), constant per fish, for individual variation
# As `state.Fishes.fins`: sweeps, lifts, mouth, dorsal fin, tail, soft rays, wave, pelvic fins,
# twists, lag of the tail.
FINS = slice(12, 26)
KIND = 26  # index of the species in the scene
# Share of the pixels drawn while two levels cross-fade; 0: all. f > 0 draws the first f of an even
# pattern, f < 0 the last -f.
FADE = 27
DISPLAY = 28  # share of mating colours, 0 to 1
FISH = 29  # index of the fish in the world
INSTANCE_COLUMNS = 30

# Lamps: right of, above and ahead of the pilot's eye, cm; turned inward and down, rad.
LAMPS_CM, LAMPS_TURNED = (48.0, -26.0, 10.0), (0.06, 0.02)

MOST_BITES = 16  # traces of feeding that a picture shows, as `bites.glsl` ...
BITE_CM = 7.0  # ... and their radius
SHOWN_STOCK = 0.97  # share of the food that is left where a trace still shows
LEAST_PART = 1024  # instances for which another thread pays
# Bounding spheres hold the nodes; the surface reaches a little farther.
ENLARGED = 1.1
NEVER_COARSE = np.zeros(len(LEVELS) - 1)  # thresholds without levels of detail


def resting_instances(number: int) -> Array:
    """Make instances (number, 30) of unturned fishes at the origin with their fins at ease.

    They have the size of the recorded fish, and the first pose of the first species.
    """
    rows = np.zeros((number, INSTANCE_COLUMNS), np.float32)
    rows[:, SCALE], rows[:, ORIENTATION.start], rows[:, FINS] = 1.0, 1.0, FINS_AT_EASE
    return rows


@dataclass(frozen=True)
class RenderScene:
    """Data of a world that rendering needs once."""

    species: tuple[Species, ...]
    control_points: (
        Array  # (rows, 426, 3) float32 cm: recorded frames of all species, then live fishes
    )
    recorded_length_cm: tuple[float, ...]  # per species
    terrain: Array  # (n, n) float32 cm, height of the seabed, row i is y, column j is x
    terrain_half_width_cm: float  # the terrain spans [-w, w] in x and y
    water: Water
    pillars: Array = field(default_factory=lambda: np.zeros((0, 4)))  # (k, 4) as `state.Sea` has it
    rocks: Array = field(default_factory=lambda: np.zeros((0, 7)))  # (k, 7) likewise
    # (k, 4): x and y in cm, bubbles per second, diameter of the largest in cm
    vents: Array = field(default_factory=lambda: np.zeros((0, 4)))
    reef: Reef = field(default_factory=lambda: empty(Reef, k=0))
    grade: Grade = UNGRADED


@dataclass(frozen=True)
class Batch:
    """Consecutive instances of a view at one level of detail, the farthest first."""

    level: int
    first: int
    count: int
    fading: bool = False  # each fish is there twice, at two levels; not so with specks


class Lamps(NamedTuple):
    """The lamps of the submarine: left and right."""

    places: Array  # (2, 3) cm
    ways: Array  # (2, 3) unit vectors along the beams


@dataclass(frozen=True)
class Packet:
    """One frame of a world."""

    time_s: float  # world time, interpolated
    views: tuple[View, ...]
    # (m, 30) float32, sorted by batch; a fish is there once for each view that sees it
    instances: Array
    # For each view: batches at rest, coarsest first, then fading ones.
    batches: tuple[tuple[Batch, ...], ...]
    plankton: Array  # (p, 3) float32 cm, all specks
    hidden: int  # fishes culled away
    # Control points (r, 426, 3) float32 cm of simulated fishes, which replace the rows of the scene
    # from `live_row` on.
    live_points: Array = field(default_factory=lambda: np.zeros((0, 426, 3), np.float32))
    live_row: int = 0
    passing_cm_s: tuple[float, float, float] = (0.0, 0.0, 0.0)  # velocity of the submarine
    vessel: Array | None = None  # (3,) cm, position of the submarine; None: that of the eyes
    hook: Array | None = None  # (3,) cm, position of its bend; None: no hook in the water
    bait: bool = False  # True if bait is on the hook
    # Leaves of seaweed in sight, fine ones first; the number of fine ones; and the leaves (v, k)
    # that each view sees, None: all.
    leaves: Array = field(default_factory=lambda: np.zeros((0, LEAF_TEXELS, 4), np.float32))
    fine_leaves: int = 0
    leaves_seen: Bools | None = None
    # Indices of the plankton that each view sees; None: all.
    plankton_seen: tuple[Ints, ...] | None = None
    lines: Lines = NO_LINES  # of diagrams
    lined: int | None = None  # number of views with lines, the first ones; None: all
    current_cm_s: tuple[float, float] | None = None  # None: as in the scene
    lamps: Lamps | None = None  # None while they are off
    hour: float | None = None  # of the day; None: as in the scene
    # Places in sight where growth was eaten, cm, and the share that is gone (k, 4) float32, nearest
    # first.
    bites: Array = field(default_factory=lambda: np.zeros((0, 4), np.float32))


@dataclass(frozen=True)
class PackOptions:
    """Options that limit the content of a packet."""

    detail: float = 1.0  # factor on the pixels by which levels of fishes and leaves are chosen
    growth: float = 1.0  # share of the clusters of seaweed
    culling: bool = True  # leave out what no view sees
    lod: bool = True  # choose levels of detail; otherwise everything is at its finest
    dots: bool = False  # draw the smallest fishes as dots, not as specks


PLAIN = PackOptions()


def make_scene(world: World) -> RenderScene:
    """The constant part of a world."""
    return RenderScene(
        species=world.species,
        control_points=world.library.control_points,
        recorded_length_cm=tuple(float(x) for x in world.library.recorded_length),
        terrain=world.state.sea.heights,
        terrain_half_width_cm=world.state.sea.half_width,
        water=world.scenario.water,
        grade=world.scenario.grade,
        pillars=world.state.sea.pillars,
        rocks=world.state.sea.rocks,
        vents=np.array(
            [(*v.position_cm, v.rate_per_s, v.size_cm) for v in world.scenario.vent]
        ).reshape(-1, 4),
        reef=world.state.reef,
    )


def pack(
    world: World,
    views: Sequence[View],
    alpha: float,
    options: PackOptions = PLAIN,
    *,
    memory: LodState | None = None,
    lines: Lines = NO_LINES,
    pilot: CameraPose | None = None,
) -> Packet:
    """Pack the frame `alpha` (0 to 1) of the way from the last tick to the current one.

    `memory` holds the levels of the frame before and is updated; without it no fish fades from one
    level to another. `pilot` is the pose of the submarine's pilot, None: interpolated too. Writes
    the times of the stages "cull" and "pose" to `world.stages_s`.
    """
    pilot = cockpit(world.state.submarine, alpha) if pilot is None else pilot
    fishes, library = world.state.fishes, world.library
    start = time.perf_counter()
    centres = _centres(fishes, alpha)
    time_s = (world.state.tick - 1 + alpha) * TICK_S
    radii = ENLARGED * library.bounding_radius[fishes.species] * fishes.length
    reach = IN_SIGHT * world.scenario.water.visibility_cm
    arrays = view_arrays(views)
    pixels, distance = coverage(centres, radii, fishes.length, arrays, reach, options.culling)
    pixels[~fishes.alive] = OUT_OF_SIGHT
    # Coarse levels would cut the crests of waves along a body, differently for body and fins: such
    # fishes are drawn one level finer.
    wavy = np.array([one.spine is not None for one in world.species])[fishes.species]
    memory = empty_lod_state(len(pixels)) if memory is None else memory
    thresholds = thresholds_of(options.detail, options.dots) if options.lod else NEVER_COARSE
    update_levels(pixels, wavy, thresholds, time_s, memory)
    order, shares, starts = draw_order(distance, time_s, len(LEVELS), memory)
    culled = time.perf_counter()
    state = world.state
    limits = LeafLimits(reach, options.detail, options.growth, options.culling, options.lod)
    leaves, fine_leaves, leaves_seen, lacking = leaves_in_sight(
        state.sea.seaweed, state.seaweed, arrays, limits
    )
    specks, bounds = plankton_in_sight(
        state.sea.plankton, state.sea.absent, arrays, options.culling
    )
    tiny = np.zeros(len(order), np.bool_)
    for own in starts:  # the coarsest level comes first
        tiny[own[0] : own[len(LEVELS) - SPECK]] = True
    instances = _instances(world, centres, (order, shares, tiny), alpha)
    live_points = _skin_live(world, order)
    world.stages_s["cull"] = culled - start
    world.stages_s["pose"] = time.perf_counter() - culled
    batches = tuple(
        tuple(
            Batch(len(LEVELS) - 1 - k % len(LEVELS), first, end - first, k >= len(LEVELS))
            for k, (first, end) in enumerate(pairwise(own))
            if end > first
        )
        for own in starts.tolist()
    )
    return Packet(
        time_s=time_s,
        views=tuple(views),
        instances=instances,
        batches=batches,
        plankton=world.state.sea.plankton.copy(),
        plankton_seen=tuple(specks[a:b] for a, b in pairwise(bounds.tolist())),
        hidden=int((pixels < 0.0).sum()),
        live_points=live_points,
        live_row=len(library.entry),
        passing_cm_s=_velocity(world),
        vessel=pilot.eye,
        hook=_hook(world.state.sea, alpha),
        bait=bool(world.state.sea.catch[0] in (SINKING, HANGING)),
        leaves=leaf_texels(state.seaweed, leaves, lacking, alpha),
        fine_leaves=fine_leaves,
        leaves_seen=leaves_seen,
        lines=lines,
        current_cm_s=world.flowing_cm_s,
        lamps=lamps_of(pilot) if world.state.submarine.lights[0] else None,
        hour=_hour(world.scenario.water, time_s),
        bites=_bites(world.state.sea, views[0].eye if views else pilot.eye, arrays),
    )


def instances_of(world: World, who: Ints, alpha: float) -> Array:
    """Write the instances (k, 30) of fishes (k,), in sight or not, and the poses of live ones."""
    fishes = world.state.fishes
    centres = _centres(fishes, alpha)
    drawn = who, np.zeros(len(who), np.float32), np.zeros(len(who), np.bool_)
    instances = _instances(world, centres, drawn, alpha)
    _skin_live(world, who)
    return instances


def _centres(fishes: Fishes, alpha: float) -> Array:
    before = fishes.previous_position
    return np.asarray(before + np.float32(alpha) * (fishes.position - before))


def _instances(
    world: World, centres: Array, drawn: tuple[Ints, Array, Bools], alpha: float
) -> Array:
    instances = np.empty((len(drawn[0]), INSTANCE_COLUMNS), np.float32)
    groups = world.state.fishes, world.library, centres, drawn, alpha, instances
    share(_write_instances, np.arange(len(instances)), LEAST_PART, *groups)
    return instances


def _hour(water: Water, time_s: float) -> float | None:
    """Hour of the day at a time of a dive, None while the clock stands still."""
    return hour_at(water.hour, water.day_minutes, time_s) if water.day_minutes else None


def _bites(sea: Sea, eye: Array, views: ViewArrays) -> Array:
    """The places (k, 4) nearest to an eye where growth was eaten, and the share that is gone.

    Those that no view sees are left out.
    """
    eaten = np.flatnonzero(sea.stock < SHOWN_STOCK)
    if not len(eaten):
        return np.zeros((0, 4), np.float32)
    away = ((sea.site_place[eaten] - eye) ** 2).sum(axis=1)
    nearest = eaten[np.argsort(away, kind="stable")[:MOST_BITES]]
    # In the frustum of a view is what is on the inner side of all of its planes.
    inside = views.planes[..., :3] @ sea.site_place[nearest].T + views.planes[..., 3:]
    nearest = nearest[(inside > -BITE_CM).all(axis=1).any(axis=0)]
    return np.column_stack([sea.site_place[nearest], 1.0 - sea.stock[nearest]]).astype(np.float32)


def lamps_of(pilot: CameraPose) -> Lamps:
    """The lamps of a submarine whose pilot has this pose."""
    axes = pilot.axes
    side = np.array([[-1.0], [1.0]])
    places = pilot.eye + (side * (1.0, 0.0, 0.0) * LAMPS_CM + (0.0, *LAMPS_CM[1:])) @ axes
    turn, down = LAMPS_TURNED
    ways = np.concatenate([-side * np.sin(turn), 0 * side - np.sin(down), 0 * side + 1.0], axis=1)
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    return Lamps(places, ways @ axes)


def _velocity(world: World) -> tuple[float, float, float]:
    """Velocity of the submarine over the last tick, cm/s."""
    submarine = world.state.submarine
    x, y, z = (submarine.position - submarine.previous_position) / TICK_S
    return float(x), float(y), float(z)


def _hook(sea: Sea, alpha: float) -> Array | None:
    """Interpolated position of the hook, None if it is out of the water."""
    state = sea.catch[0]
    if state in (STOWED, LANDED):
        return None
    velocity = {SINKING: -sea.tackle[3], HOOKED: sea.tackle[3]}.get(int(state), 0.0)
    return np.asarray(sea.hook - (0.0, 0.0, (1.0 - alpha) * TICK_S * velocity))


def _skin_live(world: World, order: Ints) -> Array:
    """Control points (r, 426, 3) of live fishes, up to the last slot in use.

    Written to the library's rows, which `motor.pose` reads too. Slots of fishes out of sight keep
    old values.
    """
    live, library = world.state.live, world.library
    table = library.control_points[len(library.entry) :]
    if not len(table):
        return table
    seen = np.isin(live.fish, order)
    pairs = table.reshape(len(seen), 2, *table.shape[1:])
    nodes = live.nodes.reshape(len(seen), 2, *live.nodes.shape[1:])
    kinds = world.state.fishes.species[live.fish[seen]]
    for kind in np.unique(kinds):
        slots = np.flatnonzero(seen)[kinds == kind]
        coupling = Coupling(*(part[kind] for part in library.coupling))
        pairs[slots] = place(coupling, nodes[slots])
    used = np.flatnonzero(live.fish >= 0)
    return table[: 2 * (used[-1] + 1)] if len(used) else table[:0]


@kernel
def _write_instances(
    rows: Ints, fishes: Fishes, library: Library, centres: Array,
    drawn: tuple[Ints, Array, Bools], alpha: float, out: Array,
) -> None:  # fmt: skip
    """Write the instances of the fishes `drawn`: who, their shares, and whether as specks."""
    order, shares, tiny = drawn
    phase = np.empty(fishes.fin_phase.shape[1], np.float32)
    # Element by element: results of whole rows would be allocated, and take seconds to compile.
    for k in rows:
        i, row = order[k], out[k]
        row[SCALE] = fishes.scale[i]
        before, after = fishes.previous_orientation[i], fishes.orientation[i]
        place, turn, fins = row[POSITION], row[ORIENTATION], row[FINS]
        for axis in range(3):
            place[axis] = centres[i, axis]
        dot, size = 0.0, 0.0
        for axis in range(4):
            dot += before[axis] * after[axis]
        old = 1.0 - alpha if dot >= 0.0 else alpha - 1.0
        for axis in range(4):
            turn[axis] = old * before[axis] + alpha * after[axis]
            size += turn[axis] ** 2
        for axis in range(4):
            turn[axis] /= np.sqrt(size)
        a, b, weight = pose_at(fishes, library, i, alpha)
        row[ROW_A], row[ROW_B], row[WEIGHT] = a, b, weight
        row[IDENTITY] = fishes.identity[i]
        if tiny[k] and fishes.rested[i] > 0:  # a speck shows slow fins alone
            for fin in range(len(fins)):
                fins[fin] = fishes.fins[i, fin]
        else:
            fins_at(fishes, library, i, alpha, fins, phase)
        row[KIND] = fishes.species[i]
        row[FADE] = shares[k]
        row[DISPLAY] = fishes.display[i]
        row[FISH] = i
