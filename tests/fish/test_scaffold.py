"""Scaffolds of outlines: inside the fish, as heavy as its water, and stable."""

import numpy as np
import pytest
from msgspec import structs

from subsea.base.system import resource_path
from subsea.biomechanics.body import build_body
from subsea.biomechanics.solver import STEP, longest_step
from subsea.fish.outline_file import read_outline
from subsea.fish.scaffold import DENSITY, MARGIN, bearable, fit_scaffold, volumes_at
from subsea.fish.species import load_species, muscular_names
from subsea.fish.surface import along
from subsea.studio.checks import static_checks

OUTLINES = sorted(resource_path("docs/outlines").glob("*.toml"))


@pytest.mark.parametrize("path", OUTLINES, ids=[path.stem for path in OUTLINES])
def test_a_fitted_body_passes_all_checks_of_a_body(path):
    surface = read_outline(path, None, None)
    body = fit_scaffold(surface)
    plain = load_species("fusilier")
    dressed = structs.replace(plain, body=body, surface=surface)
    assert not [text for severity, text in static_checks(dressed) if severity]
    assert body.mass == pytest.approx(DENSITY * volumes_at(surface, body.stations).sum(), rel=0.01)


@pytest.mark.parametrize("name", muscular_names())
def test_fitted_shipped_fishes_have_about_the_scaffold_that_they_have(name):
    species = load_species(name)
    body = fit_scaffold(species.surface, species.length_cm)
    ours, theirs = (np.array(one.stations) / one.length for one in (body, species.body))
    np.testing.assert_allclose(ours, theirs, atol=0.1)
    # Sections of the water: body and fins at the rings, and the edge of the tail.
    ours, theirs = (np.array(one.section_heights) for one in (body, species.body))
    assert np.abs(np.log(ours[[0, 1, 2, 5]] / theirs[[0, 1, 2, 5]])).max() < 0.6
    assert 0.7 < body.mass / species.body.mass < 1.3


def test_an_unbearable_body_is_softened_to_its_margin():
    stiff = structs.replace(load_species("fusilier").body, muscle_stiffness=4000.0, viscosity=0.5)
    soft = bearable(stiff)
    limit, _ = longest_step(build_body(soft))
    assert limit / STEP == pytest.approx(MARGIN, rel=0.01) and limit >= MARGIN * STEP
    assert soft.muscle_stiffness / stiff.muscle_stiffness == pytest.approx(
        soft.cross_stiffness / stiff.cross_stiffness, rel=0.01
    )
    assert bearable(soft) == soft


def test_fins_count_in_the_heights_of_the_water():
    surface = load_species("emperor_angelfish").surface
    bare = structs.replace(surface, dorsal=None, ventral=None)
    with_fins, without = (fit_scaffold(one).spans for one in (surface, bare))
    ring = 3
    at = np.array([fit_scaffold(surface).stations[ring + 1] / 22.0])
    body = along(surface.back, at)[0] - along(surface.belly, at)[0]
    assert without[ring] == pytest.approx(22.0 * body, rel=0.01)
    assert with_fins[ring] > 1.2 * without[ring]
