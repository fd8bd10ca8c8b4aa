"""Sheets lifted from photographs."""

import numpy as np
import pytest

from subsea.fish import paint, sheet_layout
from subsea.fish.species import load_species
from subsea.fish.surface import SUNK, along, points_along
from subsea.studio.deformable_mesh import copy_meshes, transform
from subsea.studio.fitting import find_fish
from subsea.studio.lift import lift_sheet, mesh_mask, pull_push, rasterize
from subsea.studio.side_view import centred_matrix, make_fish_meshes

MAGENTA = (255, 0, 255)


def crop(sheet, frame):
    return sheet_layout.crop(sheet.transpose(2, 0, 1), frame).transpose(1, 2, 0).astype(int)


def texel(species, sheet, s, y):
    body = crop(sheet, sheet_layout.BODY)
    top = sheet_layout.half_height(species.surface)
    front, rear = sheet_layout.borders(species.surface)
    column = int((s - front) / (rear - front) * body.shape[1])
    return body[int((y + top) / (2 * top) * body.shape[0]), column]


@pytest.fixture(scope="module")
def clownfish():
    return load_species("clownfish")


@pytest.fixture(scope="module")
def marked(clownfish):
    """A fish on magenta whose red is the distance from the snout, its meshes and its mask."""
    plan = clownfish.surface
    matrix = centred_matrix(800.0, 600.0, plan)
    meshes = make_fish_meshes(plan, matrix)
    x = (np.arange(800) - matrix[0, 2]) / matrix[0, 0]
    y = (np.arange(600) - matrix[1, 2]) / matrix[1, 1]
    picture = np.zeros((600, 800, 3), np.uint8)
    picture[..., 0] = (60 + 150 * x).clip(0, 255)
    picture[..., 1] = (128 - 300 * y[:, None]).clip(0, 255)
    fish = mesh_mask(meshes, picture.shape)
    picture[~fish] = MAGENTA
    return picture, meshes, fish


def test_every_place_of_the_flank_has_the_colour_of_its_own_place(clownfish, marked):
    picture, meshes, fish = marked
    sheet = lift_sheet(picture, meshes, clownfish, fish)
    assert sheet.shape == (640, 1024, 4) and sheet.dtype == np.uint8
    for s, y in ((0.1, 0.05), (0.3, 0.1), (0.5, -0.1), (0.7, 0.0), (0.9, 0.05), (0.95, -0.06)):
        red, green = texel(clownfish, sheet, s, y)[:2]
        assert red == pytest.approx(60 + 150 * s, abs=3)
        assert green == pytest.approx(128 - 300 * y, abs=4)


def test_the_other_flank_is_its_mirror_image(clownfish, marked):
    picture, meshes, fish = marked
    other = copy_meshes(meshes)
    transform(other, np.diag([-1.0, 1.0]), np.array([399.5, 0.0]), np.zeros(2))
    mirrored = lift_sheet(np.ascontiguousarray(picture[:, ::-1]), other, clownfish, fish[:, ::-1])
    plain = lift_sheet(picture, meshes, clownfish, fish)
    assert np.abs(mirrored.astype(int) - plain).mean() < 0.5


def test_fins_have_their_own_colours_and_go_on_within_the_body(clownfish, marked):
    picture, meshes, fish = marked
    sheet = lift_sheet(picture, meshes, clownfish, fish)
    plan = clownfish.surface.dorsal
    dorsal = crop(sheet, sheet_layout.DORSAL)
    share, up = 0.5, 0.8
    base = plan.base[0] + (plan.base[1] - plan.base[0]) * share
    edge = points_along(plan.edge, np.array([share]))[0]
    root = SUNK * along(clownfish.surface.back, np.array([base]))[0]
    s, y = base + up * (edge[0] - base), root + up * (edge[1] - root)
    red, green, _, alpha = dorsal[int(up * dorsal.shape[0]), int(share * dorsal.shape[1])]
    assert red == pytest.approx(60 + 150 * s, abs=5)
    assert green == pytest.approx(128 - 300 * y, abs=8)
    assert 150 < alpha <= 255
    assert (dorsal[0, :, 3] == 255).all()


def test_the_background_is_removed(clownfish, marked):
    picture, meshes, fish = marked
    for told in (fish, None):
        sheet = lift_sheet(picture, meshes, clownfish, told)
        for frame in (sheet_layout.BODY, sheet_layout.DORSAL, sheet_layout.VENTRAL):
            part = crop(sheet, frame)
            blue = part[..., 2] - np.minimum(part[..., 0], part[..., 1])
            assert blue.max() < 40  # of 255 in the background; the fish has no blue
    # And at the coarsest mipmap neither: what lies beyond the outline goes on in its colours.
    body = crop(lift_sheet(picture, meshes, clownfish, fish), sheet_layout.BODY)
    assert body[-1, :, 2].max() < 40 and body[0, :, 2].max() < 40


def changed(meshes, scale, by=(0.0, 0.0)):
    """Meshes that are larger than the fish, or beside it, by shares of its length."""
    other = copy_meshes(meshes)
    middle = meshes.body.nodes.reshape(-1, 2).mean(axis=0)
    transform(other, scale * np.eye(2), middle, meshes.length * np.array(by))
    return other


@pytest.mark.parametrize(
    ("scale", "by", "gap"),
    [(1.4, (0.0, 0.0), 0), (1.0, (0.1, 0.12), 0), (0.5, (0.0, 0.35), 0), (1.0, (0.0, 0.0), 30)],
    ids=["larger", "moved", "beside", "gap"],
)
def test_no_pixel_outside_of_the_fish_comes_into_the_sheet(scale, by, gap, clownfish, marked):
    picture, meshes, fish = marked
    fish, picture = fish.copy(), picture.copy()
    x, y = np.round(meshes.body.nodes.reshape(-1, 2).mean(axis=0)).astype(int)
    fish[y - gap : y + gap, x - gap : x + gap] = False
    picture[~fish] = MAGENTA
    sheet = lift_sheet(picture, changed(meshes, scale, by), clownfish, fish).astype(int)
    blue = sheet[..., 2] - np.minimum(sheet[..., 0], sheet[..., 1])
    assert blue[sheet[..., 3] > 0].max() < 40  # of 255 in the background; the fish has no blue


def test_the_body_is_opaque_and_gaps_in_fins_stay_gaps(clownfish, marked):
    picture, meshes, fish = marked
    fish, picture = fish.copy(), picture.copy()
    edge = meshes.fins["dorsal"].mesh.nodes[1, 5].astype(int)
    fish[edge[1] - 12 : edge[1] + 20, edge[0] - 6 : edge[0] + 6] = False
    picture[~fish] = MAGENTA
    sheet = lift_sheet(picture, meshes, clownfish, fish)
    body = crop(sheet, sheet_layout.BODY)
    front, rear = sheet_layout.borders(clownfish.surface)
    tail = int((clownfish.surface.tail.begin - front) / (rear - front) * body.shape[1])
    assert (body[:, :tail, 3] == 255).all()
    dorsal = crop(sheet, sheet_layout.DORSAL)
    assert dorsal[-6, :, 3].min() < 40
    assert np.median(dorsal[-6, :, 3]) > 180


def test_light_from_above_is_removed_but_not_a_dark_back(clownfish, marked):
    _, meshes, fish = marked
    y = np.linspace(1.0, 0.0, 600)[:, None, None] * np.ones((1, 800, 3))
    for picture, evened in ((60 + 130 * y, True), (60 + 130 * (1 - y), False)):
        sheet = lift_sheet(picture.astype(np.uint8), meshes, clownfish, fish)
        back, belly = (texel(clownfish, sheet, 0.4, h)[:3].mean() for h in (0.14, -0.14))
        own = [picture[np.round(400 - 700 * h).astype(int)].mean() for h in (0.14, -0.14)]
        # Of what the back is brighter than the belly little is left, or all of the opposite.
        if evened:
            assert own[0] > 1.25 * own[1] and 0.95 * belly < back < 1.2 * belly
        else:
            assert back < 0.85 * belly


def test_paired_fins_take_the_photographs_colours(clownfish, marked):
    _, meshes, fish = marked
    grey = np.where(fish[..., None], np.uint8(70), np.uint8(200)) * np.ones(3, np.uint8)
    pectoral = crop(lift_sheet(grey, meshes, clownfish, fish), sheet_layout.PECTORAL)
    seen = pectoral[pectoral[..., 3] > 100][:, :3]
    assert np.ptp(seen, axis=1).mean() < 12  # no orange is left
    painted = crop(paint.paint(clownfish), sheet_layout.PECTORAL)
    np.testing.assert_array_equal(pectoral[..., 3] > 0, painted[..., 3] > 0)


@pytest.mark.nightly
def test_a_species_is_lifted_from_a_photograph_of_itself(clownfish, clownfish_photo):
    """Painted, photographed, found and lifted: the sheet is the painted one again, about."""
    photograph = clownfish_photo.photograph
    one = find_fish(photograph, clownfish.surface)
    sheet = lift_sheet(photograph.colour, one.meshes, clownfish, one.mask)
    painted = paint.paint(clownfish)
    off = []
    for s in np.linspace(0.1, 0.75, 30):
        for y in np.linspace(-0.08, 0.08, 9):
            colours = [texel(clownfish, a, s, y)[:3] for a in (sheet, painted)]
            off.append(np.abs(np.subtract(*colours)).mean())
    assert np.median(off) < 12
    assert np.mean(off) < 30


def test_colours_bleed_beyond_and_stay_within():
    values = np.zeros((64, 96, 3), np.float32)
    share = np.zeros((64, 96), np.float32)
    share[20:40, 30:60] = 1.0
    values[20:40, 30:60] = (0.2, 0.5, 0.9)
    values[share == 0] = 7.0  # never seen
    out = pull_push(values, share)
    np.testing.assert_allclose(out, np.broadcast_to((0.2, 0.5, 0.9), out.shape), atol=1e-3)


def test_meshes_are_drawn_linear_between_their_places():
    y, x = np.mgrid[:5, :7].astype(float)
    out = rasterize(np.stack([4 * x + 3, 3 * y + 2], 2), np.stack([x, y], 2), (30, 40))
    assert np.isnan(out[0, 0]).all() and np.isfinite(out[2:15, 3:28]).all()
    assert out[8, 13] == pytest.approx((2.5, 2.0))
