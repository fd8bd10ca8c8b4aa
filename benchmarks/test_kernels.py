"""Compiled kernels beside plain alternatives that do the same, in one run.

Each group is one piece of work. The alternatives show the cost of a library, or of copying the same
memory, which is a lower bound. Results are compared before anything is timed.
"""

import numpy as np
import pytest
from numba import njit
from scipy.interpolate import BSpline
from scipy.linalg import solveh_banded
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from subsea.biomechanics.body import (
    HALF_BANDWIDTH,
    NODES,
    TRIANGLE_WEIGHTS,
    TRIANGLES,
    UNITS,
    build_body,
)
from subsea.biomechanics.simulation import at_rest, simulate
from subsea.biomechanics.solver import ROWS, STEPS_PER_TICK, factorize, substitute
from subsea.biomechanics.water import add_water_force
from subsea.fish.species import load_species
from subsea.frame.packet import pack
from subsea.geometry.curves import DEGREE, basis_table
from subsea.geometry.solids import height_at
from subsea.geometry.vector import vector
from subsea.habitat.current import flow_at
from subsea.habitat.plankton import drift
from subsea.habitat.seaweed import step_seaweed
from subsea.lab.profiling.paper_tables import place_nodes
from subsea.motor.playback import play
from subsea.perception.grid import make_grid, nearest
from subsea.scenario.load import load_scenario
from subsea.state import Clock
from subsea.submarine.vessel import NEUTRAL
from subsea.view.culling import OUT_OF_SIGHT, coverage, view_arrays
from subsea.view.display_rigs import cockpit, views_for
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S

MANY = 10_000
NEAREST = 6
REACH_CM = 500.0


@pytest.fixture(scope="module")
def ocean():
    """Ten thousand fishes in the open ocean, awake."""
    world = create_world(load_scenario("open-ocean")[0], fish=MANY)
    for _ in range(30):
        step(world, NEUTRAL)
    return world


@pytest.fixture(scope="module")
def bay():
    """The peaceful bay, awake."""
    world = create_world(load_scenario("peaceful")[0])
    for _ in range(30):
        step(world, NEUTRAL)
    return world


@pytest.fixture
def rng():
    return np.random.default_rng(4)


def timed(benchmark, group, of, work, *arguments):
    """Time `work`; the first call compiles."""
    benchmark.group, benchmark.name = group, of
    work(*arguments)
    benchmark(work, *arguments)


def copied(benchmark, group, of, *arrays):
    """Time copying arrays: the least that reading and writing them costs."""
    there = [np.empty_like(array) for array in arrays]

    def copy():
        for array, other in zip(arrays, there, strict=True):
            np.copyto(other, array)

    timed(benchmark, group, of, copy)


# The body: 23 nodes, 69 equations in a band of 8


@pytest.fixture
def system(rng):
    """A matrix as the semi-implicit step has it (23, 23), and its load (23, 3)."""
    A = np.diag(rng.uniform(20, 200, NODES))
    for i, j in UNITS:
        eta = rng.uniform(0, 10)
        A[[i, j], [i, j]] += eta
        A[[i, j], [j, i]] -= eta
    return A, rng.normal(0, 100, (NODES, 3))


@njit(cache=True)
def solved(band, load, band_room, load_room):
    band_room[:] = band
    load_room[:] = load
    factorize(band_room)
    substitute(band_room, load_room)


@pytest.mark.parametrize("of", ["kernel", "LAPACK, banded", "LAPACK, dense"])
def test_solve(benchmark, system, of):
    A, load = system
    group = "one solve, three right-hand sides (Tu eq. 4.12)"
    band, padded = np.zeros((ROWS, HALF_BANDWIDTH + 1)), np.zeros((ROWS, 3))
    padded[:NODES] = load
    for k in range(HALF_BANDWIDTH + 1):
        band[: NODES - k, k] = np.diagonal(A, k)
    rooms = np.empty_like(band), np.empty_like(padded)
    solved(band, padded, *rooms)
    lower = np.ascontiguousarray(band[:NODES].T)
    expected = np.linalg.solve(A, load)
    np.testing.assert_allclose(rooms[1][:NODES], expected, rtol=1e-8)
    np.testing.assert_allclose(solveh_banded(lower, load, lower=True), expected, rtol=1e-8)
    if of == "kernel":
        timed(benchmark, group, of, solved, band, padded, *rooms)
    elif of == "LAPACK, banded":
        timed(benchmark, group, of, lambda: solveh_banded(lower, load, lower=True))
    else:
        timed(benchmark, group, of, np.linalg.solve, A, load)


def water_force(x, v, water, drag):
    """Tu eq. 4.3 in numpy, all triangles at once."""
    a, b, c = np.moveaxis(x[TRIANGLES], 1, 0)
    n = np.cross(b - a, c - a)
    twice = np.linalg.norm(n, axis=1)
    n /= twice[:, None]
    u = v[TRIANGLES].mean(axis=1) - water
    outward = np.maximum((n * u).sum(axis=1), 0.0)
    size = -drag * TRIANGLE_WEIGHTS * 0.5 * twice * np.linalg.norm(u, axis=1) * outward / 3.0
    force = np.zeros_like(x)
    np.add.at(force, TRIANGLES, (size[:, None] * n)[:, None, :])
    return force


@pytest.mark.parametrize("of", ["kernel", "numpy"])
def test_water(benchmark, rng, of):
    x = build_body(load_species("fusilier").body).rest
    v, water, force = rng.normal(0, 2, (NODES, 3)), np.zeros(3), np.zeros((NODES, 3))
    add_water_force(x, v, water, 1.0, force)
    np.testing.assert_allclose(force, water_force(x, v, water, 1.0), atol=1e-9)
    group = "force of the water on 78 triangles (Tu eq. 4.3)"
    if of == "kernel":
        timed(benchmark, group, of, add_water_force, x, v, water, 1.0, force)
    else:
        timed(benchmark, group, of, water_force, x, v, water, 1.0)


# One fish, one tick


@pytest.mark.parametrize("of", ["played back", "simulated"])
def test_motion(benchmark, ocean, of):
    group = "motion of 10 000 fishes, one tick"
    if of == "played back":
        fishes = ocean.state.fishes
        timed(benchmark, group, of, play, fishes, ocean.library, TICK_S)
        return
    body = build_body(load_species("fusilier").body)
    state, rest = at_rest(body), np.zeros((STEPS_PER_TICK, 12))

    def all_of_them():
        for _ in range(MANY):
            simulate(body, state, rest)

    benchmark.group, benchmark.name = group, of
    simulate(body, state, rest)
    benchmark.pedantic(all_of_them, rounds=5)


def nodes_in_numpy(fishes, nodes):
    """SMC eq. 12 for all nodes of all fishes."""
    w = fishes.weight[:, None, None]
    body = fishes.scale[:, None, None] * ((1 - w) * nodes[fishes.row_a] + w * nodes[fishes.row_b])
    real, imaginary = fishes.orientation[:, None, :1], fishes.orientation[:, None, 1:]
    twice = 2 * np.cross(imaginary, body)
    return fishes.position[:, None] + body + real * twice + np.cross(imaginary, twice)


@pytest.mark.parametrize("of", ["kernel", "numpy", "memory copy of what it writes"])
def test_nodes(benchmark, ocean, of):
    fishes, nodes = ocean.state.fishes, ocean.library.nodes
    out = np.empty((MANY, NODES, 3), np.float32)
    place_nodes(fishes, nodes, out)
    np.testing.assert_allclose(out, nodes_in_numpy(fishes, nodes), atol=0.01)
    group = "23 nodes of 10 000 fishes in the world (SMC eq. 12)"
    if of == "kernel":
        timed(benchmark, group, of, place_nodes, fishes, nodes, out)
    elif of == "numpy":
        timed(benchmark, group, of, nodes_in_numpy, fishes, nodes)
    else:
        copied(benchmark, group, of, out)


# A surface


@pytest.mark.parametrize("of", ["table, numpy", "scipy"])
def test_surface(benchmark, rng, of):
    """Half a body: 9 × 21 control points at 15 × 39 places."""
    control, samples = rng.normal(0, 1, (9, 21, 3)), (15, 39)
    tables = [basis_table(n, m) for n, m in zip((9, 21), samples, strict=True)]
    tap = np.arange(DEGREE + 1)

    def by_table():
        u, v = tables
        near = control[
            (u.first[:, None] + tap)[:, None, :, None], v.first[None, :, None, None] + tap
        ]
        return np.einsum("ua,vb,uvabx->uvx", u.weight, v.weight, near, optimize=True)

    knots = [
        np.concatenate([np.zeros(DEGREE), np.linspace(0, 1, n - DEGREE + 1), np.ones(DEGREE)])
        for n in (9, 21)
    ]
    places = [np.linspace(0, 1, m) for m in samples]

    def by_scipy():
        rows = BSpline(knots[0], control, DEGREE)(places[0])
        return BSpline(knots[1], rows.swapaxes(0, 1), DEGREE)(places[1]).swapaxes(0, 1)

    np.testing.assert_allclose(by_table(), by_scipy(), atol=1e-12)
    group = "half a body's surface, 585 points (SMC §7.2)"
    timed(benchmark, group, of, by_scipy if of == "scipy" else by_table)


# Many fishes in the sea


@njit(cache=True)
def nearest_of_all(points, chosen, cell, reach, found, gaps):
    grid = make_grid(points, chosen, cell)
    for i in range(len(points)):
        nearest(grid, vector(points[i]), reach, i, found[i], gaps[i], 0.5 * cell)


@pytest.mark.parametrize("of", ["kernel", "scipy's k-d tree"])
def test_neighbours(benchmark, ocean, of):
    points = ocean.state.fishes.position.astype(np.float64)
    chosen, slots = np.arange(MANY), np.empty(MANY, np.int64)
    found, gaps = np.empty((MANY, NEAREST), np.int64), np.empty((MANY, NEAREST))

    def by_tree():
        return cKDTree(points).query(points, NEAREST + 1, distance_upper_bound=REACH_CM)

    work = nearest_of_all, points, chosen, 60.0, REACH_CM, found, gaps, slots
    work[0](*work[1:])
    np.testing.assert_allclose(gaps, by_tree()[0][:, 1:], rtol=1e-9)
    group = "six nearest of each of 10 000 fishes"
    if of == "kernel":
        timed(benchmark, group, of, *work)
    else:
        timed(benchmark, group, of, by_tree)


@pytest.mark.parametrize("of", ["kernel", "numpy", "memory copy of what it reads"])
def test_culling(benchmark, ocean, of):
    fishes = ocean.state.fishes
    centres = fishes.position
    radii = ocean.library.bounding_radius[fishes.species] * fishes.length
    views = views_for("mono", (1280, 720), cockpit(ocean.state.submarine, 1.0))
    planes = views[0].planes

    def in_numpy():
        away = centres @ planes[:, :3].T + planes[:, 3]
        seen = (away >= -radii[:, None]).all(axis=1)
        return seen, np.linalg.norm(centres - views[0].eye, axis=1)

    pixels, _ = coverage(centres, radii, fishes.length, view_arrays(views))
    assert ((pixels != OUT_OF_SIGHT) == in_numpy()[0]).mean() > 0.999
    group = "which of 10 000 spheres are in sight, and how far away"
    if of == "kernel":
        timed(benchmark, group, of, coverage, centres, radii, fishes.length, view_arrays(views))
    elif of == "numpy":
        timed(benchmark, group, of, in_numpy)
    else:
        copied(benchmark, group, of, centres, radii)


@pytest.mark.parametrize("of", ["kernel", "memory copy of what it writes"])
def test_packing(benchmark, ocean, of):
    views = views_for("mono", (1280, 720), cockpit(ocean.state.submarine, 1.0))
    group = "a frame's packet with 10 000 fishes, culled"
    packet = pack(ocean, views, 1.0)
    if of == "kernel":
        timed(benchmark, group, of, pack, ocean, views, 1.0)
    else:
        copied(benchmark, group, of, packet.instances)


@njit(cache=True)
def all_heights(heights, half_width, points, out):
    for k in range(len(points)):
        out[k] = height_at(heights, half_width, points[k, 0], points[k, 1])


@pytest.mark.parametrize("of", ["kernel", "scipy"])
def test_heights(benchmark, ocean, of):
    sea = ocean.state.sea
    points, out = ocean.state.fishes.position[:, :2].astype(np.float64), np.empty(MANY)
    steps = (len(sea.heights) - 1) / (2 * sea.half_width)

    def by_scipy():
        places = (points + sea.half_width).T[::-1] * steps
        return map_coordinates(sea.heights, places, order=1, mode="nearest", output=np.float64)

    all_heights(sea.heights, sea.half_width, points, out)
    np.testing.assert_allclose(out, by_scipy(), atol=0.01)
    group = "height of the seabed below 10 000 places"
    if of == "kernel":
        timed(benchmark, group, of, all_heights, sea.heights, sea.half_width, points, out)
    else:
        timed(benchmark, group, of, by_scipy)


@pytest.mark.parametrize("of", ["kernel", "memory copy of what it writes"])
def test_specks(benchmark, bay, of):
    sea, clock = bay.state.sea, Clock(bay.state.seed, bay.state.tick, TICK_S)
    group = f"{len(sea.plankton)} specks among rocks, one tick"
    if of == "kernel":
        specks, flow = np.arange(len(sea.plankton)), flow_at(bay.current_cm_s, 1.0)
        timed(benchmark, group, of, drift, specks, sea, bay.rock_cells, flow, clock)
    else:
        copied(benchmark, group, of, sea.plankton, sea.absent)


@pytest.mark.parametrize("of", ["kernel", "memory copy of what it writes"])
def test_leaves(benchmark, bay, of):
    state, clock = bay.state, Clock(bay.state.seed, bay.state.tick, TICK_S)
    far = bay.scenario.water.visibility_cm
    group = f"{len(state.seaweed.node)} leaves, one tick"
    if of == "kernel":
        flow = flow_at(bay.current_cm_s, 1.0)
        who = np.arange(len(state.sea.seaweed))
        given = who, state.seaweed, state.fishes, state.sea, bay.rock_cells, flow, far, clock
        timed(benchmark, group, of, step_seaweed, *given)
    else:
        copied(benchmark, group, of, state.seaweed.node, state.seaweed.previous)
