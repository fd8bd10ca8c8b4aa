"""Preview of one fish: its orientation, skin and motion."""

import numpy as np
import pytest
from msgspec import structs

from subsea.fish.paint import paint
from subsea.fish.species import load_species
from subsea.fish.surface import rest_control_points
from subsea.render.fish.preview import FishPreview, Orbit

SIZE = (320, 180)


@pytest.fixture(scope="module")
def clownfish():
    return load_species("clownfish")


@pytest.fixture(scope="module")
def points(clownfish):
    return rest_control_points(clownfish.surface, clownfish.length_cm, clownfish.body.stations[2])


@pytest.fixture
def specimen(context, clownfish):
    specimen = FishPreview(context, clownfish, paint(clownfish))
    yield specimen
    specimen.release()


def covered(picture):
    """Position of the fish in the picture."""
    background = picture[0, 0].astype(int)
    return np.abs(picture.astype(int) - background).max(axis=2) > 12


def seen(specimen, points, *orbit, **options):
    specimen.draw(points, Orbit(*orbit), SIZE, **options)
    return specimen.read_pixels()


def test_a_fish_from_four_sides(specimen, points, same_picture):
    sides = [seen(specimen, points, *orbit) for orbit in ((), (0.8, 0.3), (3.6, -0.4), (0.0, 1.5))]
    same_picture("specimen", np.vstack([np.hstack(sides[:2]), np.hstack(sides[2:])]))


def test_it_heads_left_fills_the_picture_and_nothing_is_cut_off(specimen, points):
    fish = covered(seen(specimen, points))
    columns = np.flatnonzero(fish.any(axis=0))
    assert 0 < columns[0] < 0.3 * SIZE[0] and 0.7 * SIZE[0] < columns[-1] < SIZE[0] - 1
    assert not fish[[0, -1]].any()
    left, right = fish[:, columns[0] : columns[0] + 12], fish[:, columns[-1] - 12 : columns[-1]]
    assert right.sum() > left.sum()  # the tail is blunter than the snout


def test_closer_is_larger_and_the_limits_hold(specimen, points):
    whole = covered(seen(specimen, points)).sum()
    assert covered(seen(specimen, points, 0.0, 0.0, 0.5)).sum() == pytest.approx(whole / 4, rel=0.1)
    assert Orbit().zoomed(1e9).zoom < 100 and Orbit().zoomed(1e-9).zoom > 0.01
    assert abs(Orbit().moved(0.0, 9.0).tilt) < np.pi / 2


def test_it_moves_with_its_control_points(specimen, points):
    before = covered(seen(specimen, points))
    after = covered(seen(specimen, points + (0.0, 3.0, 0.0)))
    rows = [np.flatnonzero(one.any(axis=1)).mean() for one in (before, after)]
    assert rows[1] < rows[0] - 5  # up in the picture


def test_another_shape_and_another_sheet(specimen, points, clownfish):
    before = seen(specimen, points)
    bare = structs.replace(
        clownfish,
        surface=structs.replace(clownfish.surface, pectoral=None, pelvic=None),
    )
    specimen.dress(bare)
    without = seen(specimen, points)
    assert covered(without).sum() < covered(before).sum() - 50
    green = np.full_like(paint(clownfish), (20, 200, 20, 255))
    specimen.dress(clownfish, green)
    dressed = seen(specimen, points)
    red, other = dressed[covered(dressed)][:, 0], dressed[covered(dressed)][:, 1]
    assert other.mean() > 2 * red.mean()
    specimen.dress(clownfish, paint(clownfish))
    np.testing.assert_array_equal(seen(specimen, points), before)


def test_another_size_is_another_texture(specimen, points):
    first = specimen.draw(points, Orbit(), SIZE)
    assert specimen.draw(points, Orbit(), SIZE) is first
    second = specimen.draw(points, Orbit(), (200, 100))
    assert second.size == (200, 100) and specimen.read_pixels().shape == (100, 200, 3)
