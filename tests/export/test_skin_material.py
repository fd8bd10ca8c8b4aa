"""Roughness and metal of skins follow the gloss and the silver of a species."""

import numpy as np

from subsea.export.clips import Model
from subsea.export.skin_material import metal_image, roughness
from subsea.fish.species import load_species, shipped_species

NOTHING = np.zeros((0, 3))


def _model(gloss: float, silver: float, colour: tuple[int, int, int]) -> Model:
    sheet = np.full((8, 6, 4), 255, np.uint8)
    sheet[..., :3] = colour
    return Model("fish", 20.0, NOTHING, NOTHING, NOTHING, NOTHING.astype(np.int32), 0, 0, {}, sheet,
                 gloss, silver)  # fmt: skip


def test_glossier_skin_is_less_rough():
    rough = [roughness(_model(gloss, 0.0, (0, 0, 0))) for gloss in (0.0, 0.3, 1.0)]
    assert rough == [0.65, 0.515, 0.2]
    by_gloss = sorted(
        (plan.skin.gloss, roughness(_model(plan.skin.gloss, 0.0, (0, 0, 0))), name)
        for name, plan in ((name, load_species(name)) for name in shipped_species())
    )
    assert by_gloss[-1][2] == "hardyhead_silverside"
    assert by_gloss[0][1] > 0.55 and by_gloss[-1][1] < 0.35


def test_only_pale_parts_of_a_silvery_fish_are_metal():
    assert metal_image(_model(0.5, 0.0, (255, 255, 255))) is None
    for colour, metal in (((255, 255, 255), 0.8), ((40, 40, 40), 0.0), ((255, 40, 40), 0.0)):
        image = metal_image(_model(0.5, 0.8, colour))
        assert image is not None and image.shape == (4, 3, 3)
        assert abs(image[..., 2] / 255.0 - metal).max() < 0.01
        assert abs(image[..., 1] / 255.0 - roughness(_model(0.5, 0.8, colour))).max() < 0.01
