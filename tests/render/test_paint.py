"""The painted skins."""

import numpy as np
import pytest

from subsea.render.paint import EDGE, SNOUT, half_height, paint
from subsea.species import load_species, species_names

SIZE = (256, 128)


@pytest.fixture(scope="module", params=species_names())
def species(request):
    return load_species(request.param)


def texel(species, picture, s, y):
    top = half_height(species.surface)
    column = int((s - SNOUT) / (EDGE - SNOUT) * picture.shape[1])
    row = int((y + top) / (2 * top) * picture.shape[0])
    return picture[row, column].astype(int)


def test_a_skin_covers_the_fish(species):
    picture = paint(species, SIZE)
    assert picture.shape == (128, 256, 4)
    assert picture.dtype == np.uint8
    np.testing.assert_array_equal(picture, paint(species, SIZE))


def test_the_body_is_opaque_and_the_fins_are_not(species):
    picture = paint(species, SIZE)
    surface = species.surface
    assert texel(species, picture, 0.4, 0.0)[3] == 255
    middle = surface.dorsal.edge[len(surface.dorsal.edge) // 2]
    assert texel(species, picture, middle[0], middle[1] - 0.008)[3] < 255


def test_the_eye_is_where_the_surface_has_it(species):
    eye = species.surface.eye
    picture = paint(species)
    pupil = texel(species, picture, eye.at, eye.height)
    iris = texel(species, picture, eye.at + 0.77 * eye.radius, eye.height)
    assert pupil[:3].max() < 60
    assert iris[:3].max() > pupil[:3].max() + 60


def test_the_tail_has_its_colour(species):
    picture = paint(species, SIZE)
    red, green, blue = texel(species, picture, species.surface.tail.begin + 0.05, 0.0)[:3]
    assert red > green > blue  # both species wear yellow there
