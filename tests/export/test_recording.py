"""A scene holds what the dive plays back, frame by frame."""

import numpy as np
import pytest

from subsea.dive.directed_camera import tour_steering
from subsea.dive.start import ready_world
from subsea.export.recording import SceneFilmOptions, continuous, tint_of
from subsea.export.scene import Scene
from subsea.fish.mesh import BODY, DETAILS, fish_mesh, species_vertices, surface_points
from subsea.fish.species import load_species
from subsea.geometry.rotation import matrix
from subsea.motor.pose import control_points_world, nodes_world
from subsea.scenario.shoals import find_fish
from subsea.world.step import step

MOUTH_END, TAIL = 0.25, 0.7  # body lengths: between these neither jaws nor tail fin move the skin


def test_bodies_are_where_playback_has_them(dive: Scene, short_dive: SceneFilmOptions) -> None:
    """In every frame of every fish: mixed rows, glides, gradual turns, and a simulated fish.

    Played back again by a world that nothing records, on another way: `control_points_world`.
    """
    world = ready_world(short_dive.loaded)
    steer = tour_steering(world, "auto")
    library, kinds, far = world.library, world.state.fishes.species, []
    mesh = fish_mesh(DETAILS[short_dive.detail])
    bodies = []  # of each fish: in all frames, some vertices, and their numbers in the mesh
    for column, fish in enumerate(dive.fishes):
        surface = world.species[kinds[fish.number]].surface
        own = species_vertices(surface, mesh, DETAILS[short_dive.detail])
        middle = (mesh.vertices[:, 12] == BODY) & (own[:, 0] > MOUTH_END) & (own[:, 0] < TAIL)
        points, _ = dive.points(column)
        bodies.append((points[:, middle[own[:, 2] >= 0]], np.flatnonzero(middle)))
    turning = gliding = 0
    for frame in range(1, dive.frames):
        while world.state.tick < frame:
            step(world, steer(world))
        fishes = world.state.fishes
        rows = fishes.row_a[fishes.row_a < len(library.level)]
        turning += int((library.level[rows] != 0).sum())
        gliding += int((np.abs(fishes.row_a - fishes.row_b) > 1).sum())
        for column, (fish, (points, middle)) in enumerate(zip(dive.fishes, bodies, strict=True)):
            control = control_points_world(fishes, library, fish.number)
            if column in dive.poses.live:  # the skin of a simulated fish follows its nodes
                weights = library.coupling.weights[kinds[fish.number]]
                control = weights @ nodes_world(fishes, library, fish.number)
            there = surface_points(control, mesh.vertices[middle], mesh.base[middle])
            here = points[frame] @ matrix(dive.rotation[frame, column]).T
            here += dive.position[frame, column]
            far.append(np.abs(here - there).max() / fish.length_cm)
    assert max(far) < 1e-4
    assert turning > 100 and gliding > 100  # there is something to compare
    assert [len(shapes) for _, shapes in dive.poses.live.values()] == [dive.frames]


def test_names_are_those_of_the_fish_finder(dive: Scene, short_dive: SceneFilmOptions) -> None:
    scenario = short_dive.loaded.scenario
    for fish in dive.fishes:
        species, _, number = fish.name.rpartition("_")
        assert find_fish(f"{species}:{int(number)}", scenario) == fish.number
        assert dive.models[fish.model].name == species
        size = fish.scale * dive.models[fish.model].length_cm
        assert size == pytest.approx(fish.length_cm, rel=1e-5)


def test_rotations_never_jump_to_the_other_sign(dive: Scene) -> None:
    for rotation in (dive.rotation, dive.camera.rotation):
        np.testing.assert_allclose(np.linalg.norm(rotation, axis=-1), 1.0, atol=1e-6)
        assert ((rotation[1:] * rotation[:-1]).sum(axis=-1) > 0.9).all()
    flipped = np.array([[1.0, 0, 0, 0], [-1.0, 0, 0, 0], [1.0, 0, 0, 0]])
    np.testing.assert_array_equal(continuous(flipped), np.tile(flipped[0], (3, 1)))


def test_tints_differ_between_fishes_about_their_species() -> None:
    species = load_species("fusilier")
    tints = np.array([tint_of(species, identity) for identity in np.linspace(0.0, 0.999, 400)])
    np.testing.assert_allclose(tints.mean(axis=0), 1.0, atol=0.02)
    assert 0.005 < tints.std(axis=0).max() < 0.3
