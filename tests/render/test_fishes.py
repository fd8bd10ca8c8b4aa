"""The vertex shader against numpy, and the levels of detail against each other."""

from itertools import pairwise

import moderngl
import numpy as np
import pytest
from msgspec import structs
from scipy.interpolate import BSpline

from subsea.kinematics.rotation import matrix
from subsea.kinematics.surface import DORSAL, FIN_U, FIN_V, LEFT, RIGHT, VENTRAL, U, V
from subsea.render import Renderer
from subsea.render.fishes import (
    BODY,
    FIN,
    INSTANCE_ATTRIBUTES,
    INSTANCE_FORMAT,
    PECTORAL,
    VERTEX_ATTRIBUTES,
    VERTEX_FORMAT,
    fish_mesh,
    mesh_level,
)
from subsea.render.shaders import set_uniforms, source
from subsea.repertoire import read_repertoire
from subsea.resources import resource_path
from subsea.species import load_species


@pytest.fixture(scope="module")
def program(context):
    varyings = ("v_world", "v_normal")
    program = context.program(vertex_shader=source("fishes.vert"), varyings=varyings)
    yield program
    program.release()


def shaded(context, program, scene, mesh, packet, stiff=0.0):
    """World positions and normals (n, 3) of one fish's vertices, as the shader has them."""
    rows, points = scene.control_points.shape[:2]
    table = np.zeros((rows, points, 4), np.float32)
    table[..., :3] = scene.control_points
    texture = context.texture((points, rows), 4, table.tobytes(), dtype="f4")
    texture.use(0)
    vertices = context.buffer(mesh.vertices.tobytes())
    instances = context.buffer(packet.instances.tobytes())
    kept = [name for name in VERTEX_ATTRIBUTES if name in program]
    assert kept == list(VERTEX_ATTRIBUTES)
    array = context.vertex_array(
        program,
        [
            (vertices, VERTEX_FORMAT, *VERTEX_ATTRIBUTES),
            (instances, INSTANCE_FORMAT, *INSTANCE_ATTRIBUTES),
        ],
    )
    out = context.buffer(reserve=len(mesh.vertices) * 24)
    target = context.simple_framebuffer((1, 1))  # without a window nothing else is bound
    target.use()
    length = scene.recorded_length_cm[0]
    set_uniforms(program, u_table=0, u_length=length, u_stiff=stiff)
    array.transform(out, moderngl.POINTS, vertices=len(mesh.vertices), instances=1)
    result = np.frombuffer(out.read(), np.float32).reshape(-1, 6)
    for held in (array, out, target, vertices, instances, texture):
        held.release()
    return result[:, :3], result[:, 3:]


def surface(control, u, v):
    """Points and normals of a clamped spline patch (nu, nv, 3) at parameters (n,), by scipy."""

    def basis(count, t, slope):
        degree = min(2, count - 1)
        inner = np.linspace(0, 1, count - degree + 1)
        knots = np.concatenate([np.zeros(degree), inner, np.ones(degree)])
        spline = BSpline(knots, np.eye(count), degree)
        return spline.derivative()(t) if slope else spline(t)

    nu, nv = control.shape[:2]
    mixed = [
        np.einsum("ni,nj,ijc->nc", basis(nu, u, du), basis(nv, v, dv), control)
        for du, dv in ((0, 0), (1, 0), (0, 1))
    ]
    normal = np.cross(mixed[1], mixed[2])
    return mixed[0], normal


@pytest.mark.parametrize("species", [0, 1])
@pytest.mark.parametrize("level", [0, 1, 2])
def test_positions_and_normals_are_those_of_the_spline(
    context, program, scene, make_packet, fish, species, level
):
    one = fish(species, (30.0, -12.0, -150.0), heading=0.8, weight=0.35, scale=1.3)
    packet = make_packet([one])
    mesh = fish_mesh(scene.species[species].surface, level)
    position, normal = shaded(context, program, scene, mesh, packet)
    row = packet.instances[0].astype(np.float64)
    table = scene.control_points.astype(np.float64)
    control = (1 - row[10]) * table[int(row[8])] + row[10] * table[int(row[9])]
    R = matrix(row[4:8])
    checked = 0
    for patch, shape, part, side in (
        (LEFT, (U, V), BODY, -1),
        (RIGHT, (U, V), BODY, 1),
        (DORSAL, (FIN_U, FIN_V), FIN, 1),
        (VENTRAL, (FIN_U, FIN_V), FIN, -1),
    ):
        mine = (mesh.vertices[:, 17] == part) & (mesh.vertices[:, 16] == side)
        u, v = mesh.vertices[mine, 18].astype(float), mesh.vertices[mine, 19].astype(float)
        body, across = surface(control[patch].reshape(*shape, 3), u, v)
        expected = row[:3] + (row[3] * body) @ R.T
        np.testing.assert_allclose(position[mine], expected, atol=2e-4)
        size = np.linalg.norm(across, axis=1, keepdims=True)
        across = across / np.maximum(size, 1e-12) @ R.T * (-side if part == BODY else 1)
        solid = size[:, 0] > 0.5
        np.testing.assert_allclose(normal[mine][solid], across[solid], atol=2e-3)
        checked += mine.sum()
    assert checked > 0.8 * len(mesh.vertices)


def test_normals_of_the_body_point_outward(context, program, scene, make_packet, fish):
    packet = make_packet([fish(1, (0.0, 0.0, 0.0), heading=0.0)])
    mesh = fish_mesh(scene.species[1].surface, 0)
    position, normal = shaded(context, program, scene, mesh, packet)
    flank = (mesh.vertices[:, 17] == BODY) & (mesh.vertices[:, 18] == 0.5)
    flank &= (mesh.vertices[:, 19] > 0.2) & (mesh.vertices[:, 19] < 0.7)
    # Heading along x: the right side lies at negative y.
    assert (np.sign(normal[flank, 1]) == -mesh.vertices[flank, 16]).all()
    assert (np.sign(position[flank, 1]) == -mesh.vertices[flank, 16]).mean() > 0.9


def test_pectoral_fins_sweep_outward(context, program, scene, make_packet, fish):
    mesh = fish_mesh(scene.species[0].surface, 0)
    paddles = mesh.vertices[:, 17] == 2
    reach = []
    for sweep in (0.0, 0.8):
        packet = make_packet([fish(0, (0, 0, 0), heading=0.0, weight=0.0, pectoral=(sweep, sweep))])
        position, _ = shaded(context, program, scene, mesh, packet)
        reach.append(-position[paddles, 1] * mesh.vertices[paddles, 16])
    assert reach[1].max() > reach[0].max() + 1.0


def test_fins_fold_and_the_tail_spreads_unless_they_are_stiff(
    context, program, scene, make_packet, fish
):
    mesh = fish_mesh(scene.species[0].surface, 0)
    still, moved = (make_packet([fish(0, (0, 0, 0))]) for _ in range(2))
    moved.instances[0, 17:] = 0.5, 0.4  # folded by half, spread
    change = {}
    for stiff in (0.0, 1.0):
        places = [shaded(context, program, scene, mesh, p, stiff)[0] for p in (still, moved)]
        change[stiff] = np.abs(places[0] - places[1]).max(axis=1)
    fins, tail = mesh.vertices[:, 17] == FIN, mesh.vertices[:, 13] < -0.95
    assert change[0.0][fins].max() > 0.5
    assert change[0.0][tail].max() > 0.5
    assert change[1.0].max() == 0.0


@pytest.mark.parametrize("species", [0, 1])
def test_levels_agree_in_silhouette(context, scene, make_packet, fish, species):
    size = (240, 160)
    renderer = Renderer(context, scene, size)
    renderer.draw(make_packet([], size=size))
    empty = renderer.read_pixels().astype(int)
    shapes = []
    for level in range(3):
        one = fish(species, (0, 24, -200), heading=2.8, level=level)
        renderer.draw(make_packet([one], size=size))
        shapes.append(np.abs(renderer.read_pixels() - empty).max(axis=2) > 2)
    renderer.release()
    assert shapes[0].mean() > 0.08
    for coarser, least in ((1, 0.97), (2, 0.93)):
        both, either = shapes[0] & shapes[coarser], shapes[0] | shapes[coarser]
        assert both.sum() / either.sum() > least


def test_a_wing_has_a_level_base_and_a_pointed_end():
    plan = load_species("fusilier").surface
    wing = structs.replace(plan.pectoral, wing=True)
    vertices = fish_mesh(structs.replace(plan, pectoral=wing), 0).vertices
    vertices = vertices[vertices[:, 17] == PECTORAL]
    np.testing.assert_array_equal(vertices[:, 4:7] - (1, 0, 0), 0)
    chord = [
        np.ptp(vertices[np.isclose(vertices[:, 18], share), 14]) / wing.width
        for share in np.unique(vertices[:, 18])
    ]
    assert chord[0] > 0.9
    assert chord[-1] < 0.1
    assert (np.diff(chord) < 0).all()
    assert vertices[:, 13].max() == pytest.approx(wing.length)
    assert vertices[:, 13].min() < 0  # the root lies inside the body


@pytest.mark.parametrize("level", [0, 1, 2])
def test_the_body_is_closed(level):
    """Every edge belongs to two triangles, but at the tail, which is thinner than a pixel."""
    mesh = fish_mesh(load_species("fusilier").surface, level)
    place = np.round(mesh.vertices[:, 13:16], 6)
    _, same = np.unique(place, axis=0, return_inverse=True)
    solid = same.reshape(-1)[mesh.triangles[: mesh.solid]]
    edges = np.concatenate([solid[:, [0, 1]], solid[:, [1, 2]], solid[:, [2, 0]]])
    edges = edges[edges[:, 0] != edges[:, 1]]
    forward, backward = ({tuple(e) for e in way} for way in (edges, edges[:, ::-1]))
    at_tail = {
        tuple(e)
        for e in edges
        if (place[:, 0][[np.flatnonzero(same == k)[0] for k in e]] < -0.85).all()
    }
    assert forward - backward <= at_tail


def test_a_far_fin_keeps_its_tip():
    plan = load_species("fusilier").surface
    tip = (0.45, 0.3)
    edge = [(0.3, 0.11), (0.43, 0.13), tip, (0.47, 0.13), (0.6, 0.1), (0.74, 0.07)]
    plan = structs.replace(plan, dorsal=structs.replace(plan.dorsal, edge=edge))
    near, far = (fish_mesh(plan, level).vertices for level in (1, 2))
    highest = [mesh[mesh[:, 17] == FIN][:, 14].max() for mesh in (near, far)]
    assert highest[1] == pytest.approx(highest[0])
    assert len(far) < len(near) / 2


def test_a_body_with_a_wave_is_never_drawn_so_coarsely_that_its_fins_come_off():
    """Where a fin rises from the eel's back, in every level and at every moment of a beat."""
    eel = load_species("ribbon_eel")
    repertoire = read_repertoire(resource_path("repertoires/ribbon_eel.h5"))
    points = repertoire.segments["swim_fast"].control_points
    for level in range(3):
        mesh = fish_mesh(eel.surface, mesh_level(eel, level))
        body, fin = (mesh.vertices[mesh.vertices[:, 17] == part] for part in (BODY, FIN))
        ridge = body[(body[:, 18] == 0) & (body[:, 16] < 0)]
        root = fin[(fin[:, 18] == 0) & (fin[:, 16] > 0)]
        for pose in points:
            a, b = (
                np.array([place(vertex, pose) for vertex in row])[:, [0, 2]]
                for row in (ridge, root)
            )
            for one in b:
                along = [_distance(one, *ends) for ends in pairwise(a)]
                assert min(along) < 0.008 * eel.length_cm


def place(vertex, pose):
    """Where a vertex of body or fin is, as the shader evaluates it."""
    rows = int(vertex[0]) + int(vertex[20]) * np.arange(3)[:, None] + np.arange(3)
    weight = vertex[1:4][:, None] * vertex[4:7]
    return np.einsum("ab,abx->x", weight, pose[np.minimum(rows, len(pose) - 1)])


def _distance(point, start, end):
    way = end - start
    share = np.clip((point - start) @ way / (way @ way), 0, 1)
    return np.linalg.norm(point - start - share * way)
