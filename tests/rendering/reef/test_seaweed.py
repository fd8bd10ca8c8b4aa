"""Drawn seaweed: ribbons along their chains, in every view."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from subsea.frame.in_sight import LEAF_NODES, LEAF_TEXELS
from subsea.habitat.seaweed import KINDS
from subsea.rendering.gl.id_buffer import SEAWEED
from subsea.rendering.output.quality import Quality
from subsea.rendering.reef.seaweed import COARSE, FINE, FRONDS, LUSH, ribbon

LUSH_TRIANGLES, FINE_TRIANGLES, COARSE_TRIANGLES = (
    2 * (a - 1) * (b - 1) for a, b in (LUSH, FINE, COARSE)
)
PLAIN = Quality(close_up=False)
NO_LEAVES = np.zeros((0, LEAF_TEXELS, 4))


def leaf(root, height=70.0, bend=0.0, width=6.0, facing=0.0, own=0.3):
    """A leaf that bends toward +x as it rises."""
    t = np.linspace(0.0, 1.0, LEAF_NODES)
    out = np.zeros((LEAF_TEXELS, 4), np.float32)
    out[:LEAF_NODES, :3] = np.array(root) + np.stack([bend * t**2, 0 * t, height * t], axis=1)
    out[LEAF_NODES] = width, facing, 0.8, own
    out[LEAF_NODES + 1] = 0.14, 0.155, 0.03, height
    return out


@pytest.fixture(scope="module")
def bed():
    """Three clusters."""
    rng = np.random.default_rng(2)
    leaves = []
    for x, y in ((-50.0, 130.0), (0.0, 200.0), (55.0, 150.0)):
        for k in range(6):
            root = x + rng.normal(0, 7), y + rng.normal(0, 7), -295.0
            leaves.append(leaf(root, rng.uniform(50, 95), rng.uniform(-5, 35), 6.0, k, k / 6))
    return np.array(leaves)


@pytest.fixture
def standing(counted, make_packet):
    """(leaves, number of fine ones, options of `counted`) -> picture, triangles."""

    def standing(leaves=NO_LEAVES, fine=0, eye=(0, 0, -235), **options):
        packet = make_packet([], eye=eye, **options)
        return counted(replace(packet, leaves=leaves, fine_leaves=fine), **options)

    return standing


def test_a_bed_of_seaweed(drawn, bed, make_packet, fish, same_picture):
    packet = make_packet([fish(1, (10, 110, -235))], eye=(0, 0, -235), pitch=-0.1)
    same_picture("seaweed", drawn(replace(packet, leaves=bed, fine_leaves=len(bed))))


def test_near_leaves_are_fine_and_far_ones_coarse_in_the_same_place(standing, bed):
    bare, triangles = standing()
    masks = []
    for fine in (len(bed), 0):
        picture, number = standing(bed, fine)
        assert number - triangles == (LUSH_TRIANGLES if fine else COARSE_TRIANGLES) * len(bed)
        masks.append(np.abs(picture - bare).max(axis=2) > 25)
    assert masks[0].mean() > 0.03
    assert (masks[0] & masks[1]).sum() > 0.7 * (masks[0] | masks[1]).sum()
    _, mixed = standing(bed, 6)
    assert mixed - triangles == 6 * LUSH_TRIANGLES + (len(bed) - 6) * COARSE_TRIANGLES


def test_a_leaf_is_where_its_chain_is(standing):
    """One leaf straight ahead: 100 cm away, from 35 cm below the eye to 35 cm above it."""
    one = leaf((0.0, 100.0, -235.0), 70.0, bend=30.0)[None]
    eye = (0, 0, -200.0)
    bare, picture = standing(eye=eye)[0], standing(one, 1, eye)[0]
    rows, columns = np.nonzero(np.abs(picture - bare).max(axis=2) > 20)
    scale = 90.0 / np.tan(np.radians(27.5)) / 100.0
    assert rows.min() == pytest.approx(90 - 35 * scale, abs=4)
    assert rows.max() == pytest.approx(90 + 35 * scale, abs=4)
    top = columns[rows < rows.min() + 6].mean()
    assert top == pytest.approx(160 + 30 * scale, abs=6)
    assert columns[rows > rows.max() - 6].mean() == pytest.approx(160, abs=4)
    width = np.bincount(rows)[rows.min() : rows.max() + 1]
    assert width[len(width) // 2] > 1.5 * width[-3]  # narrow at the root ...
    assert width[len(width) // 2] > 1.5 * width[2]  # ... and at the tip


@pytest.mark.parametrize("display", ["side-by-side", "panorama"])
def test_it_stands_in_every_view(standing, bed, display):
    bare, full = (standing(leaves, display=display)[0] for leaves in (bed[:0], bed))
    assert (np.abs(bare - full).max(axis=2) > 25).mean() > 0.01


def test_more_leaves_than_before_fit(standing, bed):
    many = np.concatenate([bed] * 30)
    one, again = (standing(leaves, len(leaves))[0] for leaves in (bed, many))
    np.testing.assert_array_equal(one, again)


def _of_kind(bed, kind):
    changed = bed.copy()
    changed[:, 0, 3] = KINDS.index(kind)
    return changed


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("close_up", [True, False])
def test_every_kind_has_its_fronds_near_and_far(counted, make_packet, bed, kind, close_up):
    quality, packet = Quality(close_up=close_up), make_packet([], eye=(0, 0, -235))
    bare, triangles = counted(packet, quality=quality)
    near = (0, LUSH_TRIANGLES) if close_up else (2, FINE_TRIANGLES)
    for fine, (level, each) in ((len(bed), near), (0, (near[0] + 1, COARSE_TRIANGLES))):
        standing = replace(packet, leaves=_of_kind(bed, kind), fine_leaves=fine)
        picture, number = counted(standing, quality=quality)
        assert number - triangles == each * len(bed) * len(FRONDS[kind][level])
        assert (np.abs(picture - bare).max(axis=2) > 20).mean() > 0.01


@pytest.mark.parametrize("kind", KINDS)
def test_the_change_of_level_does_not_show(standing, bed, kind):
    """Fine leaves that lack all of their detail cover what coarse ones cover."""
    leaves = _of_kind(bed, kind)
    bare = standing()[0]

    def mask(lacks, fine):
        lacking = leaves.copy()
        lacking[:, 1, 3] = lacks
        return np.abs(standing(lacking, fine)[0] - bare).max(axis=2) > 20

    whole, turned, coarse, gone = mask(0, 18), mask(1, 18), mask(1, 0), mask(2, 0)
    assert (turned != coarse).mean() < 0.15 * (turned != whole).mean() + 0.002
    between = [mask(share, 18).sum() for share in np.linspace(0.0, 1.0, 6)]
    assert np.abs(np.diff(between)).max() < 0.4 * max(between)
    assert not gone.any()


@pytest.mark.parametrize(("depth", "reaches"), [(40.0, True), (170.0, False)])
def test_kelp_whose_tip_is_near_the_surface_has_a_canopy(
    make_renderer, make_packet, depth, reaches
):
    """Fronds float within a hand's breadth of the surface, and do not pierce it."""
    tall = leaf((0.0, 300.0, -depth - 400.0), 400.0, bend=60.0, width=8.0)
    tall[0, 3] = KINDS.index("kelp")
    packet = make_packet([], eye=(0, 0, -60.0), pitch=0.15, size=(320, 180))
    packet = replace(packet, leaves=tall[None], fine_leaves=1)
    renderer = make_renderer((320, 180))
    renderer.draw(packet)
    maps = renderer.id_maps(packet)
    rows, columns = np.nonzero(maps.kind == SEAWEED)
    view = packet.views[0]
    inverse = np.linalg.inv((view.projection @ view.view).astype(np.float64))
    clip = np.stack(
        [(columns + 0.5) / 160.0 - 1.0, 1.0 - (rows + 0.5) / 90.0, 0 * rows, 1 + 0 * rows], axis=1
    )
    far = clip @ inverse.T
    ray = far[:, :3] / far[:, 3:] - view.eye
    forward = -view.view[2, :3].astype(np.float64)
    height = view.eye[2] + maps.depth[rows, columns] * ray[:, 2] / (ray @ forward)
    assert (height.max() > -15.0) == reaches
    assert height.max() < 0.0


def test_kinds_differ(standing, bed):
    seen = [standing(_of_kind(bed, kind), len(bed))[0] for kind in KINDS]
    for one, other in combinations(seen, 2):
        assert (np.abs(one - other).max(axis=2) > 25).mean() > 0.01


def test_a_ribbon_covers_its_rectangle_once():
    places, triangles = ribbon(5, 3)
    a, b, c = np.moveaxis(places[triangles].astype(float), 1, 0)
    u, v = b - a, c - a
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    assert (area > 0).all()
    assert area.sum() / 2 == pytest.approx(2.0)
