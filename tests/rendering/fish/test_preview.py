"""Preview of one fish: its orientation, skin and motion."""

import numpy as np
import pytest
from msgspec import structs

from subsea.fish import sheet_layout
from subsea.fish.paint import paint
from subsea.fish.sheet_layout import crop
from subsea.fish.species import load_species
from subsea.fish.surface import rest_control_points
from subsea.rendering.fish.preview import FishPreview, Orbit

SIZE = (320, 180)


@pytest.fixture(scope="module")
def clownfish():
    return load_species("clownfish")


@pytest.fixture(scope="module")
def points(clownfish):
    return rest_control_points(clownfish.surface, clownfish.length_cm, clownfish.body.stations[2])


@pytest.fixture
def preview(context, clownfish):
    preview = FishPreview(context, clownfish, paint(clownfish))
    yield preview
    preview.release()


def covered(picture):
    """Position of the fish in the picture."""
    background = picture[0, 0].astype(int)
    return np.abs(picture.astype(int) - background).max(axis=2) > 12


def seen(preview, points, *orbit, **options):
    preview.draw(points, Orbit(*orbit), SIZE, **options)
    return preview.read_pixels()


def test_a_fish_from_four_sides(preview, points, same_picture):
    sides = [seen(preview, points, *orbit) for orbit in ((), (0.8, 0.3), (3.6, -0.4), (0.0, 1.5))]
    same_picture("specimen", np.vstack([np.hstack(sides[:2]), np.hstack(sides[2:])]))


@pytest.mark.parametrize("size", [(320, 200), (96, 60), (48, 30)])
def test_a_clear_fin_takes_no_colour_of_its_neighbour_on_the_sheet(
    context, clownfish, points, size
):
    skin = paint(clownfish)
    crop(np.moveaxis(skin, 2, 0), sheet_layout.DORSAL)[:] = 0
    for region in (sheet_layout.VENTRAL, sheet_layout.PECTORAL, sheet_layout.PELVIC):
        crop(np.moveaxis(skin, 2, 0), region)[:] = np.reshape([0, 255, 0, 255], (4, 1, 1))
    preview = FishPreview(context, clownfish, skin)
    preview.draw(points, Orbit(), size)
    picture = preview.read_pixels().astype(int)
    preview.release()
    green = picture[..., 1] - picture[..., [0, 2]].max(axis=2) > 15
    assert green[size[1] // 2 :].any()
    assert not green[: size[1] // 3].any()


def test_it_heads_left_fills_the_picture_and_nothing_is_cut_off(preview, points):
    fish = covered(seen(preview, points))
    columns = np.flatnonzero(fish.any(axis=0))
    assert 0 < columns[0] < 0.3 * SIZE[0] and 0.7 * SIZE[0] < columns[-1] < SIZE[0] - 1
    assert not fish[[0, -1]].any()
    left, right = fish[:, columns[0] : columns[0] + 12], fish[:, columns[-1] - 12 : columns[-1]]
    assert right.sum() > left.sum()  # the tail is blunter than the snout


def test_closer_is_larger_and_the_limits_hold(preview, points):
    whole = covered(seen(preview, points)).sum()
    assert covered(seen(preview, points, 0.0, 0.0, 0.5)).sum() == pytest.approx(whole / 4, rel=0.1)
    assert Orbit().zoomed(1e9).zoom < 100 and Orbit().zoomed(1e-9).zoom > 0.01
    assert abs(Orbit().moved(0.0, 9.0).tilt) < np.pi / 2


def test_it_moves_with_its_control_points(preview, points):
    before = covered(seen(preview, points))
    after = covered(seen(preview, points + (0.0, 3.0, 0.0)))
    rows = [np.flatnonzero(one.any(axis=1)).mean() for one in (before, after)]
    assert rows[1] < rows[0] - 5  # up in the picture


def test_another_shape_and_another_sheet(preview, points, clownfish):
    before = seen(preview, points)
    bare = structs.replace(
        clownfish,
        row=None,  # it cannot row without
        surface=structs.replace(clownfish.surface, pectoral=None, pelvic=None),
    )
    preview.update(bare)
    without = seen(preview, points)
    assert covered(without).sum() < covered(before).sum() - 50
    green = np.full_like(paint(clownfish), (20, 200, 20, 255))
    preview.update(clownfish, green)
    dressed = seen(preview, points)
    red, other = dressed[covered(dressed)][:, 0], dressed[covered(dressed)][:, 1]
    assert other.mean() > 2 * red.mean()
    preview.update(clownfish, paint(clownfish))
    np.testing.assert_array_equal(seen(preview, points), before)


def test_another_size_is_another_texture(preview, points):
    first = preview.draw(points, Orbit(), SIZE)
    assert preview.draw(points, Orbit(), SIZE) is first
    second = preview.draw(points, Orbit(), (200, 100))
    assert second.size == (200, 100) and preview.read_pixels().shape == (100, 200, 3)


def test_the_body_shows_through_clear_pectoral_fins(context):
    """Stripes of an emperor angelfish are seen behind its fins, which are not white."""
    species = load_species("emperor_angelfish")
    points = rest_control_points(species.surface, species.length_cm, species.body.stations[2])
    preview = FishPreview(context, species, paint(species))
    whole = seen(preview, points).astype(float)
    bare = structs.replace(species.surface, pectoral=None)
    preview.update(structs.replace(species, row=None, surface=bare))
    behind = seen(preview, points).astype(float)
    preview.release()
    fins = np.abs(whole - behind).max(axis=2) > 8
    assert fins.sum() > 200
    assert whole[fins].mean() < behind[covered(behind)].mean()
    assert np.corrcoef(whole[fins].ravel(), behind[fins].ravel())[0, 1] > 0.7
