"""The vertex shader against splines, and the levels of detail against each other."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from msgspec import structs
from scipy.interpolate import BSpline

from subsea.base.system import resource_path
from subsea.fish import paint
from subsea.fish.face import GAPE_RAD
from subsea.fish.mesh import (
    ABSENT,
    BODY,
    DETAILS,
    FIN,
    PECTORAL,
    finest_basis,
    fish_mesh,
    sample_indices,
    species_vertices,
    surface_points,
)
from subsea.fish.mesh import PELVIC as PELVIC_FIN
from subsea.fish.species import load_species, shipped_species
from subsea.fish.surface import (
    DORSAL,
    FIN_U,
    FIN_V,
    LEFT,
    RIGHT,
    VENTRAL,
    U,
    V,
    rest_control_points,
)
from subsea.frame.packet import (
    FINS,
    ORIENTATION,
    POSITION,
    ROW_A,
    ROW_B,
    SCALE,
    WEIGHT,
    resting_instances,
)
from subsea.geometry.curves import greville
from subsea.geometry.rotation import matrix
from subsea.rendering.fish import fishes
from subsea.rendering.fish.fishes import AT_ONCE, FishShape
from subsea.rendering.fish.preview import FINS as AT_EASE
from subsea.rendering.fish.preview import FishPreview, Orbit
from subsea.rendering.fish.speck import dot, places, speck
from subsea.rendering.output.quality import PRESETS
from subsea.repertoire import read_repertoire
from subsea.state import DORSAL as DORSAL_FIN
from subsea.state import (
    FIN_COLUMNS,
    LAG,
    MOUTH,
    PELVIC,
    SOFT,
    TAIL,
    TWIST_LEFT,
    TWIST_RIGHT,
    WAVE_SINE,
)
from subsea.view.levels import LEVELS
from tests.support.daily import only

PART, ALONG, SIDE = 12, 13, 14  # columns of a vertex
MESHES = [fish_mesh(detail) for detail in DETAILS]


def has_paddles(name):
    """True if a species has paired fins, and no wings in their place."""
    pectoral = load_species(name).surface.pectoral
    return pectoral is not None and not pectoral.wing


def shaded(level, packet, scene, stiff=None):
    """World positions and normals (n, 3) of one fish's vertices, as the shader computes them."""
    species = scene.species
    if stiff is not None:
        species = tuple(
            structs.replace(one, surface=structs.replace(one.surface, stiff_fins=stiff))
            for one in species
        )
    shape = FishShape(species, scene.recorded_length_cm, level)
    drawn = shape.at(packet.instances[:1], scene.control_points)
    return drawn.places[0], drawn.normals[0]


def dressed(scene, species, level):
    """A mesh, and the attributes of its vertices."""
    return MESHES[level], species_vertices(
        scene.species[species].surface, MESHES[level], DETAILS[level]
    )


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
@pytest.mark.parametrize("level", range(len(DETAILS)))
def test_positions_and_normals_are_those_of_the_spline(scene, make_packet, fish, species, level):
    one = fish(species, (30.0, -12.0, -150.0), heading=0.8, weight=0.35, scale=1.3)
    packet = make_packet([one])
    mesh, own = dressed(scene, species, level)
    position, normal = shaded(level, packet, scene)
    row = packet.instances[0].astype(np.float64)
    table = scene.control_points.astype(np.float64)
    before, after = table[row[[ROW_A, ROW_B]].astype(int)]
    control = (1 - row[WEIGHT]) * before + row[WEIGHT] * after
    R = matrix(row[ORIENTATION])
    checked = 0
    for patch, shape, part, side in (
        (LEFT, (U, V), BODY, -1),
        (RIGHT, (U, V), BODY, 1),
        (DORSAL, (FIN_U, FIN_V), FIN, 1),
        (VENTRAL, (FIN_U, FIN_V), FIN, -1),
    ):
        mine = (mesh.vertices[:, PART] == part) & (mesh.vertices[:, SIDE] == side)
        u, v = mesh.vertices[mine, ALONG].astype(float), own[mine, 3]
        body, across = surface(control[patch].reshape(*shape, 3), u, v)
        expected = row[POSITION] + (row[SCALE] * body) @ R.T
        np.testing.assert_allclose(position[mine], expected, atol=2e-4)
        size = np.linalg.norm(across, axis=1, keepdims=True)
        across = across / np.maximum(size, 1e-12) @ R.T * (-side if part == BODY else 1)
        solid = size[:, 0] > 0.02
        np.testing.assert_allclose(normal[mine][solid], across[solid], atol=2e-3)
        checked += mine.sum()
    assert checked == (mesh.vertices[:, PART] <= FIN).sum()


@pytest.mark.parametrize("level", range(len(DETAILS)))
def test_many_fishes_at_once_are_as_each_alone(scene, make_packet, fish, level):
    """Of both species, with other fins, and poses in any rows."""
    kinds = [k % 2 for k in range(AT_ONCE + 9)]
    packet = make_packet([fish(kind, (30.0 * k, 0.0, 0.0)) for k, kind in enumerate(kinds)])
    fins = np.random.default_rng(2).uniform(0.0, 0.9, (len(kinds), FIN_COLUMNS))
    packet.instances[:, FINS] = fins
    shape = FishShape(scene.species, scene.recorded_length_cm, level)
    together = shape.at(packet.instances, scene.control_points)
    for k in (0, 1, AT_ONCE, AT_ONCE + 8):
        alone = shape.at(packet.instances[k : k + 1], scene.control_points)
        for values, one in zip(together, alone, strict=True):
            np.testing.assert_array_equal(values[k], one[0])


def test_normals_of_the_body_point_outward(scene, make_packet, fish):
    packet = make_packet([fish(1, (0.0, 0.0, 0.0), heading=0.0)])
    mesh, own = dressed(scene, 1, 0)
    position, normal = shaded(0, packet, scene)
    flank = (mesh.vertices[:, PART] == BODY) & (mesh.vertices[:, ALONG] == 0.5)
    flank &= (own[:, 3] > 0.2) & (own[:, 3] < 0.7)
    assert flank.sum() > 50
    # Heading along x: the right side lies at negative y.
    assert (np.sign(normal[flank, 1]) == -mesh.vertices[flank, SIDE]).all()
    assert (np.sign(position[flank, 1]) == -mesh.vertices[flank, SIDE]).mean() > 0.9


@pytest.mark.parametrize("level", range(len(DETAILS)))
def test_both_halves_meet_without_a_crease(scene, make_packet, fish, level):
    """Normals of a straight body agree at its ridges, and point ahead at the snout."""
    straight = scene.control_points.copy()
    rest = rest_control_points(scene.species[0].surface, scene.recorded_length_cm[0], 6.0)
    straight[:2] = rest
    packet = make_packet([fish(0, (0.0, 0.0, 0.0), heading=0.0)])
    mesh, own = dressed(scene, 0, level)
    still = dataclasses.replace(scene, control_points=straight)
    _, normal = shaded(level, packet, still)
    body = mesh.vertices[:, PART] == BODY
    trunk = body & (own[:, 3] > 0.05) & (own[:, 3] < 0.6)
    for ridge, up in ((0.0, 1.0), (1.0, -1.0)):
        mine = trunk & (mesh.vertices[:, ALONG] == ridge)
        left, right = (normal[mine & (mesh.vertices[:, SIDE] == side)] for side in (-1, 1))
        assert len(left) == len(right) > 4
        np.testing.assert_allclose(left, right, atol=0.03)
        assert (up * left[:, 2] > 0.7).all()
    snout = body & (own[:, 3] == 0.0)
    assert (normal[snout, 0] > 0.3).all()
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-4)


def test_pectoral_fins_sweep_outward(scene, make_packet, fish):
    mesh = MESHES[0]
    paddles = mesh.vertices[:, PART] == PECTORAL
    reach = []
    for sweep in (0.0, 0.8):
        packet = make_packet([fish(0, (0, 0, 0), heading=0.0, weight=0.0, pectoral=(sweep, sweep))])
        position, _ = shaded(0, packet, scene)
        reach.append(-position[paddles, 1] * mesh.vertices[paddles, SIDE])
    assert reach[1].max() > reach[0].max() + 1.0


def test_fins_fold_and_the_tail_spreads_unless_they_are_stiff(scene, make_packet, fish):
    mesh, own = dressed(scene, 0, 0)
    still, moved = (make_packet([fish(0, (0, 0, 0))]) for _ in range(2))
    moved.instances[0, FINS.start + np.array([DORSAL_FIN, TAIL])] = 0.5, 0.4
    change = {}
    for stiff in (False, True):
        places = [shaded(0, p, scene, stiff)[0] for p in (still, moved)]
        change[stiff] = np.abs(places[0] - places[1]).max(axis=1)
    fins = mesh.vertices[:, PART] == FIN
    tail = (mesh.vertices[:, PART] == BODY) & (own[:, 0] > 0.95)
    assert change[False][fins].max() > 0.5
    assert change[False][tail].max() > 0.5
    assert change[True].max() == 0.0


@pytest.mark.parametrize("level", range(len(DETAILS)))
def test_folded_fins_lie_lower_and_farther_back_and_face_the_same_side(
    scene, make_packet, fish, level
):
    still, folded = (make_packet([fish(1, (0, 0, 0), heading=0.0)]) for _ in range(2))
    folded.instances[0, FINS.start + np.array([DORSAL_FIN, SOFT])] = 0.5
    (a, before), (b, after) = (shaded(level, packet, scene) for packet in (still, folded))
    vertices = MESHES[level].vertices
    edge = (vertices[:, PART] == FIN) & (vertices[:, ALONG] == 1.0)
    for side in (1.0, -1.0):
        mine = edge & (vertices[:, SIDE] == side)
        assert (side * (b - a)[mine, 2]).max() < 0.0 and (b - a)[mine, 0].mean() < -0.3
        # The last ray has hardly any length, and its edge runs forwards.
        assert (before * after).sum(axis=1)[mine][:-1].min() > 0.5


@pytest.mark.parametrize("level", range(len(DETAILS)))
def test_a_wave_moves_median_fins_aside_unless_they_are_stiff(scene, make_packet, fish, level):
    """By about its amplitude times the rays' length; a moved surface has moved normals."""
    mesh, own = dressed(scene, 0, level)
    still, moved = (make_packet([fish(0, (0, 0, 0))]) for _ in range(2))
    moved.instances[0, FINS.start + WAVE_SINE] = 0.2
    fins = mesh.vertices[:, PART] == FIN
    tail = (mesh.vertices[:, PART] == BODY) & (own[:, 0] > scene.species[0].surface.tail.begin)
    for stiff in (False, True):
        (a, before), (b, after) = (shaded(level, p, scene, stiff) for p in (still, moved))
        assert np.abs(a - b)[~fins & ~tail].max() == 0.0
        if stiff:
            assert np.abs(a - b).max() == 0.0
            continue
        for side in (1.0, -1.0):
            mine = fins & (mesh.vertices[:, SIDE] == side)
            root, edge = (mine & (mesh.vertices[:, ALONG] == u) for u in (0.0, 1.0))
            rays = np.linalg.norm(a[edge] - a[root], axis=1)
            wide = np.linalg.norm(b[edge] - a[edge], axis=1)
            assert np.abs(a - b)[root].max() == 0.0
            assert 0.1 < (wide / rays).max() <= 0.2001
            assert (before[mine] * after[mine]).sum(axis=1).min() < 0.97


@pytest.mark.parametrize("level", range(len(DETAILS)))
def test_the_tail_lags_and_ripples_without_a_crack_unless_it_is_stiff(
    scene, make_packet, fish, level
):
    """Both halves move alike, most in the middle of the edge; normals follow the surface."""
    (mesh, own), tail = dressed(scene, 0, level), scene.species[0].surface.tail
    still, lagging, rippling = (make_packet([fish(0, (0, 0, 0), heading=0.0)]) for _ in range(3))
    lagging.instances[0, FINS.start + LAG] = 0.3
    rippling.instances[0, FINS.start + WAVE_SINE] = 0.14
    body = mesh.vertices[:, PART] == BODY
    left, right = (np.flatnonzero(body & (mesh.vertices[:, SIDE] == side)) for side in (-1, 1))
    u, edge = mesh.vertices[left, ALONG], own[left, 3] == 1.0
    length = scene.recorded_length_cm[0] * (1.0 - tail.begin)
    for packet in (lagging, rippling):
        (a, before), (b, after) = (shaded(level, p, scene) for p in (still, packet))
        moved = b - a
        seam = (u == 0.0) | (u == 1.0)
        np.testing.assert_allclose(moved[left][seam], moved[right][seam], atol=2e-4)
        assert np.abs(moved[body & (own[:, 0] <= tail.begin)]).max() == 0.0
        assert (before * after).sum(axis=1)[left[edge]].min() < 0.99
        assert np.array_equal(*(shaded(level, p, scene, stiff=True)[0] for p in (still, packet)))
        if packet is lagging:  # to the right: y of the world is left
            assert (moved[left[edge], 1] < 0.0).all()
            aside = np.linalg.norm(moved[left[edge]], axis=1) / length
            assert 0.05 < aside[np.abs(u[edge] - 0.5).argmin()] <= 0.3001
            assert aside[u[edge] == 0.0] > 0.1
        else:
            assert np.ptp(moved[left[edge], 1]) > 0.05 * length


def test_the_whip_of_a_ray_does_not_ripple():
    """It bends by no more than its own height."""
    species = load_species("spotted_eagle_ray")
    shape = FishShape((species,), (1.0,), 0)
    rows = resting_instances(2)
    rows[1, FINS.start + np.array([LAG, WAVE_SINE])] = 0.3, 0.14
    still, bent = shape.at(rows, rest_control_points(species.surface, 1.0, 0.0)[None]).places
    assert np.abs(bent - still)[MESHES[0].vertices[:, PART] == BODY].max() < 0.01


def test_normals_follow_the_surface_of_a_bent_tail(scene, make_packet, fish):
    """At the finest level: off from those of its triangles hardly more than at rest."""
    mesh, own = dressed(scene, 0, 0)
    still, bent = (make_packet([fish(0, (0, 0, 0))]) for _ in range(2))
    bent.instances[0, FINS.start + np.array([LAG, WAVE_SINE])] = 0.3, 0.1
    tail = (mesh.vertices[:, PART] == BODY) & (own[:, 0] > scene.species[0].surface.tail.begin)
    corners = mesh.triangles[: mesh.body]
    corners = corners[tail[corners].all(axis=1)]
    off = []
    for packet in (still, bent):
        places, normals = shaded(0, packet, scene)
        a, b, c = (places[corners[:, k]] for k in range(3))
        facing = np.cross(b - a, c - a)
        facing /= np.linalg.norm(facing, axis=1, keepdims=True)
        cosine = (facing[:, None] * normals[corners]).sum(axis=2)
        off.append(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
    assert np.sqrt((off[1] ** 2).mean()) < np.sqrt((off[0] ** 2).mean()) + 2.0


@pytest.mark.parametrize("twist", [-0.8, 0.8])
def test_a_twist_turns_the_upper_edge_of_a_pectoral_fin_ahead_or_back(
    scene, make_packet, fish, twist
):
    mesh, own = dressed(scene, 0, 0)
    still, moved = (
        make_packet([fish(0, (0, 0, 0), heading=0.0, pectoral=(1.4, 1.4))]) for _ in range(2)
    )
    moved.instances[0, FINS.start + np.array([TWIST_LEFT, TWIST_RIGHT])] = twist
    (a, _), (b, _) = (shaded(0, packet, scene) for packet in (still, moved))
    change = np.sign(twist) * (b - a)[:, 0]
    paddle = (mesh.vertices[:, PART] == PECTORAL) & (mesh.vertices[:, ALONG] > 0.3)
    for side in (-1.0, 1.0):
        mine = paddle & (mesh.vertices[:, SIDE] == side)
        assert (change[mine & (own[:, 1] > 1e-3)] > 0.0).all()
        assert (change[mine & (own[:, 1] < -1e-3)] < 0.0).all()
    assert np.abs(b - a)[mesh.vertices[:, PART] != PECTORAL].max() == 0.0


@pytest.mark.parametrize("name", [name for name in shipped_species() if has_paddles(name)])
def test_paired_fins_are_rooted_on_the_flank_where_their_species_says(name):
    species = load_species(name)
    plan, mesh = species.surface, MESHES[0]
    shape = FishShape((species,), (1.0,), 0)
    control = rest_control_points(plan, 1.0, 0.0)
    places = shape.at(resting_instances(1), control[None]).places[0]
    part, side = mesh.vertices[:, PART], mesh.vertices[:, SIDE]
    u, v = (axis.ravel() for axis in np.meshgrid(*[np.linspace(0.0, 1.0, 240)] * 2))
    flank, _ = surface(control[RIGHT].reshape(U, V, 3), u, v)
    for number, paddle in ((PECTORAL, plan.pectoral), (PELVIC_FIN, plan.pelvic)):
        mine = (part == number) & (side == 1.0) & (mesh.vertices[:, ALONG] == 0.0)
        root = places[mine].mean(axis=0)
        assert np.hypot(root[0] + paddle.at, root[1] - paddle.height) < 0.012
        assert np.linalg.norm(flank - root, axis=1).min() < 0.005


def test_pelvic_fins_fold_and_spread(scene, make_packet, fish):
    """Spread ones reach farther down and aside."""
    mesh, _ = dressed(scene, 0, 0)
    pelvic = mesh.vertices[:, PART] == PELVIC_FIN
    low, wide = [], []
    for spread in (0.0, 1.0):
        packet = make_packet([fish(0, (0, 0, 0), heading=0.0)])
        packet.instances[0, FINS.start + PELVIC] = spread
        places, _ = shaded(0, packet, scene)
        low.append(places[pelvic, 2].min())
        wide.append(np.abs(places[pelvic, 1]).max())
    assert low[1] < low[0] - 0.4 and wide[1] > wide[0] + 0.4


def _bent(rest, turn):
    """Points (n, 3) bent to an arc in the plane of x and z, by `turn` rad along their length."""
    front, rear = rest[:, 0].max(), rest[:, 0].min()
    angle = turn * ((rest[:, 0] - rear) / (front - rear) - 0.5)
    axis = (front - rear) / turn
    radius = axis - rest[:, 2]
    return np.stack([radius * np.sin(angle), rest[:, 1], axis - radius * np.cos(angle)], axis=1)


@pytest.mark.parametrize("species", [0, 1])
def test_paired_fins_turn_with_the_flank_of_a_bent_body(scene, make_packet, fish, species):
    """They keep their angle to it, and so neither stand off nor cut into the body."""
    plan, size = scene.species[species].surface, scene.recorded_length_cm[species]
    rest, mesh = rest_control_points(plan, size, 0.0), MESHES[0]
    packet = make_packet([fish(species, (0, 0, 0), heading=0.0, pectoral=(0.4, 0.4))])
    for part, paddle in ((PECTORAL, plan.pectoral), (PELVIC_FIN, plan.pelvic)):
        headings = []
        for turn in (1e-3, 1.4):
            points = scene.control_points.copy()
            points[2 * species : 2 * species + 2] = _bent(rest, turn)
            places, _ = shaded(0, packet, dataclasses.replace(scene, control_points=points))
            ways = np.zeros(2)
            for side in (-1.0, 1.0):
                mine = (mesh.vertices[:, PART] == part) & (mesh.vertices[:, SIDE] == side)
                base, tip = (
                    places[mine & (mesh.vertices[:, ALONG] == end), :2].mean(axis=0)
                    for end in (0.0, 1.0)
                )
                ways += (base - tip) / np.linalg.norm(base - tip)
            headings.append(np.arctan2(*ways[::-1]))
        assert abs(headings[0]) < 0.01
        expected = -1.4 * (0.5 - paddle.at)  # y of the world is left
        assert headings[1] == pytest.approx(expected, abs=0.07)


def test_jaws_turn_about_a_joint_behind_the_corner_of_the_mouth(scene, make_packet, fish):
    """The lower jaw turns by its full angle, the upper one by less, and nothing far behind."""
    species, size = scene.species[0], scene.recorded_length_cm[0]
    straight = scene.control_points.copy()
    straight[:2] = rest_control_points(species.surface, size, 0.0)
    still = dataclasses.replace(scene, control_points=straight)
    shut, breath, bite = (make_packet([fish(0, (0, 0, 0), heading=0.0)]) for _ in range(3))
    breath.instances[0, FINS.start + MOUTH], bite.instances[0, FINS.start + MOUTH] = 0.45, 1.0
    (before, ahead), (breathing, _), (after, turned) = (
        shaded(0, packet, still) for packet in (shut, breath, bite)
    )
    mesh, own = dressed(scene, 0, 0)
    (tip, high), (corner, low) = species.skin.mouth
    line = np.interp(own[:, 0], (tip, corner), (high, low))
    body = (mesh.vertices[:, PART] == BODY) & (own[:, 0] < 0.8 * corner)
    chin, brow = body & (own[:, 1] < line - 0.006), body & (own[:, 1] > line + 0.012)
    assert chin.sum() > 10 < brow.sum()
    joint = size * np.array([-corner - 0.25 * (corner - tip), low])
    angle = GAPE_RAD["prey"]
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    across = [0, 2]  # the plane in which it turns
    np.testing.assert_allclose(
        after[chin][:, across], joint + (before[chin][:, across] - joint) @ turn.T, atol=1e-3
    )
    np.testing.assert_allclose(after[chin, 1], before[chin, 1], atol=1e-3)
    np.testing.assert_allclose(turned[chin][:, across], ahead[chin][:, across] @ turn.T, atol=1e-3)
    risen = (after - before)[brow, 2]
    assert 0.0 < risen.max() < 0.5 * (before - after)[chin, 2].max()
    half = np.linalg.norm(breathing - before, axis=1).max()
    assert 0.0 < half < 0.3 * np.linalg.norm(after - before, axis=1).max()
    far = (mesh.vertices[:, PART] != BODY) | (own[:, 0] > 4.0 * corner)
    np.testing.assert_array_equal(after[far], before[far])


@pytest.mark.parametrize("species", ["blacktip_reef_shark", "clownfish", "spotted_eagle_ray"])
def test_an_open_mouth_is_dark_inside(context, species):
    """The face from the front; a ray's mouth lies below and stays shut."""
    kind = load_species(species)
    shown = FishPreview(context, kind, paint.paint(kind))
    points = rest_control_points(kind.surface, kind.length_cm, 0.0)

    def black(gape):
        fins = (*AT_EASE[:4], gape, *AT_EASE[5:])
        shown.draw(points, Orbit(turn=np.pi / 2), (320, 180), fins)
        return (shown.read_pixels().max(axis=2) < 50).sum()

    shut, wide = black(0.0), black(1.0)
    shown.release()
    if kind.surface.wing:
        assert wide == shut
    else:
        assert wide > shut + 60


@pytest.mark.parametrize("level", range(len(DETAILS)))
def test_fins_that_a_species_lacks_are_drawn_nowhere(level):
    plan = load_species("fusilier").surface
    finless = structs.replace(plan, dorsal=None, pelvic=None)
    mesh = MESHES[level]
    full, less = (species_vertices(one, mesh, DETAILS[level]) for one in (plan, finless))
    hidden = less[:, 2] == ABSENT
    part, side = mesh.vertices[:, PART], mesh.vertices[:, SIDE]
    np.testing.assert_array_equal(hidden, ((part == FIN) & (side > 0)) | (part == PELVIC_FIN))
    assert (full[:, 2] != ABSENT).all()


@pytest.mark.parametrize("species", [0, 1])
def test_levels_agree_in_silhouette(drawn, make_packet, fish, species):
    """All levels but specks at the size of a near fish; specks at the size of a far one."""
    size = (240, 160)
    empty = drawn(make_packet([], size=size))
    shapes = []
    for level in range(4):
        one = fish(species, (0, 24, -200), heading=2.8, level=level)
        shapes.append(np.abs(drawn(make_packet([one], size=size)) - empty).max(axis=2) > 2)
    assert shapes[0].mean() > 0.08
    for coarser, least in ((1, 0.97), (2, 0.97), (3, 0.93)):
        both, either = shapes[0] & shapes[coarser], shapes[0] | shapes[coarser]
        assert both.sum() / either.sum() > least


@pytest.mark.parametrize("species", [0, 1])
@pytest.mark.parametrize(("level", "away_cm", "least_px"), [(4, 32.0, 40), (5, 64.0, 10)])
def test_a_coarse_level_looks_like_the_one_before_it(
    drawn, make_packet, fish, species, level, away_cm, least_px
):
    """Equal size and brightness where one level replaces another: at 24 pixels, and at 12."""
    size = (60, 40)
    silhouettes, sums = [], []
    for drawn_as in (level - 1, level):
        shape, colour = np.zeros(size[::-1]), np.zeros(3)
        for k, heading in enumerate(np.linspace(0.0, 6.0, 12)):
            one = fish(species, (0.3 * k, away_cm, -200 + 0.2 * k), heading=heading, level=drawn_as)
            packets = [make_packet(f, size=size, time_s=3.0 * k) for f in ([one], [])]
            change = np.subtract(*(drawn(packet, quality=PRESETS["low"]) for packet in packets))
            shape += np.abs(change).max(axis=2) > 4
            colour += change.sum(axis=(0, 1))
        silhouettes.append(shape.sum() / 12)
        sums.append(colour / 12)
    assert silhouettes[0] > least_px
    assert silhouettes[1] == pytest.approx(silhouettes[0], rel=0.1)
    assert (np.abs(sums[1] - sums[0]) / silhouettes[0] < 12).all()  # grey levels a pixel


@pytest.mark.parametrize(("shape", "most"), [(speck(), 40), (dot(), 10)])
def test_a_coarse_level_is_closed_and_a_handful_of_triangles(shape, most):
    assert len(shape.triangles) <= most
    body = shape.triangles[~shape.thin[shape.triangles].any(axis=1)]
    edges = np.concatenate([body[:, [0, 1]], body[:, [1, 2]], body[:, [2, 0]]])
    forward, backward = ({tuple(e) for e in way} for way in (edges, edges[:, ::-1]))
    assert forward == backward
    assert len(forward) == len(edges)
    place = rest_control_points(load_species("fusilier").surface, 1.0, 0.0)[shape.points]
    a, b, c = (place[body[:, k]] for k in range(3))
    assert (a * np.cross(b, c)).sum() > 0  # its volume: triangles turn outward


def _around(number):
    """Axes (number, 3, 2) across directions that are spread evenly over the sphere."""
    k = np.arange(number) + 0.5
    z, turn = 1.0 - 2.0 * k / number, k * np.pi * (3.0 - np.sqrt(5.0))
    ring = np.sqrt(1.0 - z**2)
    side = np.stack([-np.sin(turn), np.cos(turn), 0.0 * z], axis=-1)
    upward = np.stack([-z * np.cos(turn), -z * np.sin(turn), ring], axis=-1)
    return np.stack([side, upward], axis=-1)


SIDES = _around(20)
GRID = np.stack(np.meshgrid(*[np.arange(-1.1, 1.1, 0.04)] * 2), axis=-1).reshape(-1, 2)


@pytest.mark.parametrize("name", only(["fusilier", "clownfish"], shipped_species()))
def test_a_dot_covers_as_much_as_a_speck(name):
    """Seen from 20 sides on average; pixels whose middle lies in a triangle are counted."""
    plan = load_species(name).surface
    rest, areas = rest_control_points(plan, 1.0, 0.0), []
    for shape in (speck(), dot()):
        own = places(plan, shape)
        moved = np.where(own[:, 3:] > 0.0, own[:, 3:], 1.0)
        points = rest[shape.roots] + moved * (rest[shape.points] - rest[shape.roots])
        triangles = shape.triangles[(own[:, 2] != ABSENT)[shape.triangles].all(axis=1)]
        areas.append(sum(_silhouette(points @ axes, triangles) for axes in SIDES))
    assert areas[1] == pytest.approx(areas[0], rel=0.07)


def _silhouette(points, triangles):
    """The number of points of GRID in any of the triangles of points (n, 2)."""

    def beside(begin, end):
        (dx, dy), (px, py) = (end - begin).T, (GRID[:, None] - begin).transpose(2, 0, 1)
        return dx * py - dy * px >= 0.0

    a, b, c = (points[triangles[:, k]] for k in range(3))
    left = np.array([beside(a, b), beside(b, c), beside(c, a)])
    return (left.all(axis=0) | ~left.any(axis=0)).any(axis=1).sum()


@pytest.mark.parametrize("level", range(len(LEVELS)))
@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_a_cross_fade_draws_each_pixel_exactly_once(drawn, make_packet, fish, level, share):
    """Both halves of a cross-fade at one level make the whole fish; one alone makes its share.

    A pixel drawn twice would make fins denser, and a missing pixel would show the water.
    """

    def faded(*fades):
        selves = [fish(1, (0, 24, -200), heading=2.8, level=level, fade=fade) for fade in fades]
        return drawn(make_packet(selves, size=(120, 80)), quality=PRESETS["low"])

    empty, whole, both = faded(), faded(0.0), faded(share, share - 1.0)
    one, other = faded(share), faded(share - 1.0)
    mine = np.abs(whole - empty).max(axis=2) > 2
    assert mine.sum() > 500
    firsts, seconds = ((np.abs(x - empty).max(axis=2) > 2) & mine for x in (one, other))
    assert not (firsts & seconds).any()
    assert firsts.sum() / mine.sum() == pytest.approx(share, abs=0.04)
    if level < 2:  # fine levels draw all bodies before all fins, so that these hide no fin behind
        assert (np.abs(whole - both).max(axis=2) > 1).mean() < 0.01
    else:
        np.testing.assert_array_equal(whole, both)


@pytest.mark.parametrize("level", range(len(LEVELS)))
def test_a_view_lacks_the_body_of_the_fish_whose_eye_it_is(drawn, make_packet, fish, level):
    def seen(fishes, without=-1):
        packet = make_packet(fishes, size=(120, 80))
        views = tuple(dataclasses.replace(view, without=without) for view in packet.views)
        return drawn(dataclasses.replace(packet, views=views), quality=PRESETS["low"])

    own = fish(1, (0, 24, -200), level=level, number=7)
    other = fish(0, (4, 60, -200), level=level, number=8)
    both, alone, inside = seen([own, other]), seen([other]), seen([own, other], without=7)
    assert (np.abs(both - alone).max(axis=2) > 2).sum() > 100
    np.testing.assert_array_equal(inside, alone)


def test_coarser_levels_are_decimations_of_the_finest():
    """Their control-point weights are in the finest table, number for number."""
    for controls in (U, V, FIN_V):
        samples = [set(sample_indices(controls, thinned).tolist()) for thinned in range(3)]
        assert samples[2] < samples[1] < samples[0]
        np.testing.assert_allclose(
            sample_indices(controls, 1) / (len(finest_basis(controls).first) - 1),
            greville(controls),
            atol=1e-12,
        )
    columns = slice(0, PART + 1)
    known = {
        (base, v, *row)
        for base, v, row in zip(
            MESHES[0].base, MESHES[0].v, MESHES[0].vertices[:, columns].tolist(), strict=True
        )
        if row[PART] <= FIN
    }
    for mesh in MESHES[1:]:
        for base, v, row in zip(mesh.base, mesh.v, mesh.vertices[:, columns].tolist(), strict=True):
            assert row[PART] > FIN or (base, v, *row) in known


def test_a_wing_has_a_level_base_and_a_pointed_end():
    plan = load_species("fusilier").surface
    wing = structs.replace(plan.pectoral, wing=True)
    own = species_vertices(structs.replace(plan, pectoral=wing), MESHES[0], DETAILS[0])
    mine = MESHES[0].vertices[:, PART] == PECTORAL
    along, place = MESHES[0].vertices[mine, ALONG], own[mine, :2]
    chord = [np.ptp(place[along == share, 1]) / wing.width for share in np.unique(along)]
    assert chord[0] > 0.9
    assert chord[-1] < 0.1
    assert (np.diff(chord) < 0).all()
    assert place[:, 0].max() == pytest.approx(wing.length)
    assert place[:, 0].min() < 0  # the root lies inside the body


@pytest.mark.parametrize("name", ["fusilier", "spotted_eagle_ray"])
@pytest.mark.parametrize("level", range(len(DETAILS)))
def test_the_body_is_closed(level, name):
    """Every edge belongs to two triangles, but at the tail, which is thinner than a pixel."""
    mesh = MESHES[level]
    body = mesh.vertices[:, PART] == BODY
    rest = rest_control_points(load_species(name).surface, 1.0, 0.0)
    place = np.full((len(body), 3), np.nan)
    place[body] = np.round(surface_points(rest, mesh.vertices[body], mesh.base[body]), 6)
    _, same = np.unique(place, axis=0, return_inverse=True)
    triangles = mesh.triangles[: mesh.body]
    solid = same.reshape(-1)[triangles[body[triangles].all(axis=1)]]
    assert len(solid) > 100
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
    highest = []
    for mesh, detail in zip(MESHES[2:], DETAILS[2:], strict=True):
        mine = (mesh.vertices[:, PART] == FIN) & (mesh.vertices[:, SIDE] > 0)
        highest.append(species_vertices(plan, mesh, detail)[mine, 1].max())
    assert highest[1] == pytest.approx(highest[0])
    assert len(MESHES[3].vertices) < len(MESHES[2].vertices) / 2


def test_a_body_with_a_wave_keeps_its_fins():
    """A fin rises from the eel's back in all but the coarsest level, throughout a beat."""
    eel = load_species("ribbon_eel")
    repertoire = read_repertoire(resource_path("repertoires/ribbon_eel.h5"))
    for mesh, detail in zip(MESHES[:-1], DETAILS[:-1], strict=True):
        own = species_vertices(eel.surface, mesh, detail)
        part, side, along = mesh.vertices[:, [PART, SIDE, ALONG]].T
        lines = [
            (along == 0) & (part == BODY) & (side < 0),
            (along == 0) & (part == FIN) & (side > 0),
        ]
        for pose in repertoire.segments["swim_fast"].control_points:
            ridge, root = (
                surface_points(pose, mesh.vertices[mine], own[mine, 2].astype(int))[:, [0, 2]]
                for mine in lines
            )
            for one in root:
                assert min(_distance(one, *ends) for ends in pairwise(ridge)) < (
                    0.008 * eel.length_cm
                )


def _distance(point, start, end):
    way = end - start
    share = np.clip((point - start) @ way / (way @ way), 0, 1)
    return np.linalg.norm(point - start - share * way)


def test_the_number_of_calls_does_not_depend_on_the_fishes(drawn, make_packet, fish, monkeypatch):
    """The number of calls does not depend on the number of species either."""
    made = []
    render = fishes.FishRenderer._render
    monkeypatch.setattr(fishes.FishRenderer, "_render", lambda *a: (made.append(a), render(*a)))
    calls = []
    drawn(make_packet([], size=(64, 48)))  # the first picture has a few more calls
    for number in (2, 40):
        made.clear()
        few = [
            fish(k // 10 % 2, (0, 40, -200), level=k % 5, fade=0.5 * (k % 2))
            for k in range(20 * number)
        ]
        drawn(make_packet(few, size=(64, 48)))
        calls.append(len(made))
    assert 0 < calls[0] == calls[1] <= 10


def test_a_fin_hides_no_fin_behind_it(drawn, make_packet, fish):
    """`frame.pack` puts the farther fish first: its fin shows through the nearer one's."""
    # The tip of the dorsal fin before the other's flank is hidden by its body: only fins overlap.
    near, far = fish(1, (0, 24, -200), heading=2.8), fish(1, (0, 30, -197), heading=2.8)
    right, wrong, alone = (
        drawn(make_packet(shown, size=(240, 160)), quality=PRESETS["low"])
        for shown in ([far, near], [near, far], [near])
    )
    # Where the far fish shows through or beside the near one, it shows at least as strongly.
    with_, without = ((np.abs(x - alone).max(axis=2) > 3).sum() for x in (right, wrong))
    assert with_ > without > 0
