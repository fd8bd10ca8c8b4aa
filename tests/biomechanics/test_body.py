import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from subsea.biomechanics.body import (
    HALF_BANDWIDTH,
    KINDS,
    MUSCLES,
    NODES,
    TRIANGLE_WEIGHTS,
    TRIANGLES,
    UNITS,
    body_frame,
    build_body,
    rest_nodes,
    to_body,
    to_world,
)
from subsea.biomechanics.manoeuvres import MIRROR
from subsea.geometry.rotation import matrix


def pairs():
    return {(int(i), int(j)) for i, j in UNITS}


def test_the_connectivity_is_the_one_that_the_text_describes():
    assert len(UNITS) == len(pairs()) == 91
    assert np.bincount(KINDS).tolist() == [12, 42, 37]
    assert pairs() >= {(0, 2), (2, 7), (21, 22)}
    assert [tuple(unit) for unit in UNITS[:MUSCLES]] == [(i, i + 4) for i in range(1, 13)]
    assert KINDS[[tuple(unit) for unit in UNITS].index((2, 7))] == 1
    assert KINDS[[tuple(unit) for unit in UNITS].index((0, 2))] == 2


def test_the_matrix_is_banded_and_its_skyline_has_126_entries():
    assert (UNITS[:, 1] - UNITS[:, 0]).min() > 0
    assert HALF_BANDWIDTH == 7
    first = [min([i, *(int(a) for a, b in UNITS if b == i)]) for i in range(NODES)]
    assert sum(i - start + 1 for i, start in enumerate(first)) == 126


def test_connectivity_is_the_same_left_and_right():
    mirrored = {tuple(sorted((int(MIRROR[i]), int(MIRROR[j])))) for i, j in UNITS}
    assert mirrored == pairs()


def test_the_frame_of_the_body_at_rest_is_that_of_the_world(species):
    origin, rotation = body_frame(rest_nodes(species.body))
    np.testing.assert_allclose(origin, 0, atol=1e-12)
    np.testing.assert_allclose(rotation, np.eye(3), atol=1e-12)


def test_nose_ahead_tail_behind_and_sides_where_they_belong(species):
    nodes = rest_nodes(species.body)
    assert nodes[0, 0] - nodes[22, 0] == species.body.length
    upper_left, upper_right, lower_right, lower_left = nodes[5:9]
    assert upper_left[1] > 0 > lower_left[1]
    assert upper_right[2] > 0 > upper_left[2]
    assert lower_right[2] > 0
    np.testing.assert_allclose(nodes[MIRROR] * (1, 1, -1), nodes)


def test_a_taller_back_leaves_the_belly_alone(fusilier):
    plain, tall = rest_nodes(fusilier.body), rest_nodes(fusilier.body, back=1.1)
    above = plain[:, 1] > 0
    np.testing.assert_allclose(tall[above, 1], 1.1 * plain[above, 1])
    np.testing.assert_allclose(tall[~above], plain[~above])


def test_the_masses_of_table_4_1_make_107_grams(fusilier):
    body = build_body(fusilier.body)
    np.testing.assert_allclose(body.mass.sum(), 107.03)
    np.testing.assert_allclose(
        body.mass[[0, 1, 5, 9, 13, 20, 22]], [1.1, 6.6, 11, 6.6, *[1.1] * 2, 0.165]
    )


def test_the_hull_is_closed_and_faces_outwards(species):
    a, b, c = np.moveaxis(rest_nodes(species.body)[TRIANGLES], 1, 0)
    area = np.cross(b - a, c - a) / 2 * TRIANGLE_WEIGHTS[:, None]
    np.testing.assert_allclose(area.sum(axis=0), 0, atol=1e-12)
    volume = np.sum(area * (a + b + c) / 9)
    box = 4 * max(species.body.half_widths) * max(species.body.half_heights)
    assert 0.2 * box * species.body.length < volume < box * species.body.length
    assert len(TRIANGLES) == 78


def test_the_body_has_no_hinges(species):
    body = build_body(species.body)
    stiffness = np.zeros((NODES, 3, NODES, 3))
    for (i, j), c in zip(UNITS, body.stiffness, strict=True):
        along = body.rest[j] - body.rest[i]
        block = c * np.outer(along, along) / (along @ along)
        stiffness[i, :, i] += block
        stiffness[j, :, j] += block
        stiffness[i, :, j] -= block
        stiffness[j, :, i] -= block
    modes = np.linalg.eigvalsh(stiffness.reshape(69, 69))
    assert np.sum(np.abs(modes) < 1e-9) == 6  # only the motions of a rigid body cost nothing
    assert modes[6] > 0.05


seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_the_frame_stays_orthonormal_in_deformed_bodies(known_repertoire_nodes, seed):
    rng = np.random.default_rng(seed)
    nodes = known_repertoire_nodes + rng.normal(0, 0.3, (23, 3))
    _, R = body_frame(nodes)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) > 0


@given(seeds)
def test_the_frame_moves_with_the_body(known_repertoire_nodes, seed):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    Q, shift = matrix(q / np.linalg.norm(q)), rng.normal(0, 100, 3)
    origin, R = body_frame(known_repertoire_nodes @ Q.T + shift)
    np.testing.assert_allclose(origin, shift, atol=1e-10)
    np.testing.assert_allclose(R, Q, atol=1e-10)
    body = to_body(known_repertoire_nodes @ Q.T + shift, origin, R)
    np.testing.assert_allclose(body, known_repertoire_nodes, atol=1e-9)
    np.testing.assert_allclose(
        to_world(body, origin, R), known_repertoire_nodes @ Q.T + shift, atol=1e-9
    )
