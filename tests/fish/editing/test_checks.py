"""Checks of an edited fish: shipped species pass, spoilt ones are reported."""

import numpy as np
import pytest

from subsea.fish.editing import checks
from subsea.fish.editing.checks import FAULT, GOOD, WARNING
from subsea.fish.editing.draft import read_draft, with_value, with_values
from subsea.fish.editing.proportions import with_mass
from subsea.fish.species import load_species, muscular_names, species_file, species_names


@pytest.fixture(scope="module")
def fusilier():
    return read_draft(species_file("fusilier"))


def said(findings, word):
    """The only finding that has a word in it."""
    found = [finding for finding in findings if word in finding.text]
    assert len(found) == 1, findings
    return found[0]


@pytest.mark.parametrize("name", species_names())
def test_shipped_species_stand_up_to_it(name):
    findings = checks.static_checks(load_species(name))
    assert findings and not [one for one in findings if one.severity == FAULT]
    minded = [one for one in findings if one.severity == WARNING]
    assert len(minded) <= (name == "emperor_angelfish")  # which is light for its size


@pytest.mark.parametrize("name", muscular_names())
def test_shipped_species_swim_turn_and_keep_their_shape(name):
    muscles = load_species(name).muscles
    swim = checks.try_swimming(muscles)
    assert {one.severity for one in checks.swim_checks(swim, muscles)} == {GOOD}
    assert 0.65 <= swim.strain[0] < 1 < swim.strain[1] <= 1.4
    assert swim.turned_deg == pytest.approx(muscles.turn.sharp, abs=2)


def test_speed_is_that_of_the_documentation():
    swim = checks.try_swimming(load_species("fusilier").muscles)
    assert swim.per_beat == pytest.approx(0.462, abs=0.003)
    assert swim.sweep == pytest.approx(0.192, abs=0.003)
    assert swim.speed_bl_s == pytest.approx(0.999, abs=0.01)


def with_body(draft, **keys):
    return with_values(draft, {("body", key): value for key, value in keys.items()})


def test_each_fault_is_named_with_what_to_do(fusilier):
    body = fusilier.content["body"]

    def of(draft):
        return checks.static_checks(draft.species)

    tall = [*body["half_heights"]]
    tall[1] *= 3.2
    out = said(of(with_body(fusilier, half_heights=tall)), "Ring 2")
    assert out.severity == WARNING and "Lower it" in out.text
    heavy = said(of(with_mass(fusilier, 220.0)), "sink")
    assert heavy.severity == WARNING and "Neutral" in heavy.text
    level = with_mass(fusilier, checks.displaced_cm3(fusilier.species))
    assert said(of(level), "buoyant").severity == GOOD
    front = with_body(fusilier, masses=[20.0, 9.0, 3.0, 1.5, 1.5, 1.5, 1.5])
    assert said(of(front), "forward").severity == WARNING
    thin = with_value(fusilier, ("surface", "width", 3), [0.1, -0.01])
    assert said(of(thin), "no width").severity == FAULT
    sunk = [[x, 0.4 * y] for x, y in fusilier.content["surface"]["dorsal"]["edge"]]
    assert (
        said(
            of(with_value(fusilier, ("surface", "dorsal", "edge"), sunk)), "fin lies inside"
        ).severity
        == WARNING
    )


def test_a_hull_that_is_folded_is_told():
    body = checks.build_body(load_species("fusilier").body)
    assert said(checks.check_faces(body), "78 faces").severity == GOOD
    folded = body.rest.copy()
    folded[[9, 10]], folded[[11, 12]] = folded[[12, 11]], folded[[10, 9]]  # ring 3 upside down
    finding = said(checks.check_faces(body._replace(rest=folded)), "folded")
    assert finding.severity == FAULT and "ring 2" in finding.text


def test_a_body_that_loses_its_shape_is_named_with_the_place(fusilier):
    wild = with_value(fusilier, ("swim", "contraction"), [0.6, 0.6])
    wild = with_body(wild, half_widths=[0.4, 0.5, 0.5, 0.25, 0.25])
    swim = checks.try_swimming(wild.species.muscles)
    assert not swim.sound
    (finding,) = checks.swim_checks(swim, wild.species.muscles)
    assert finding.severity == FAULT and "ring" in finding.text


def test_one_that_hardly_moves_is_sent_to_learn(fusilier):
    weak = with_value(fusilier, ("swim", "contraction"), [0.05, 0.05])
    muscles = weak.species.muscles
    findings = checks.swim_checks(checks.try_swimming(muscles), muscles)
    assert said(findings, "slowly").severity == WARNING and "Learn" in said(findings, "slowly").text
    assert said(findings, "sweeps little").severity == WARNING
    assert said(findings, "sharp turn").severity == WARNING


def test_one_too_quick_for_muscles_is_told(fusilier):
    quick = with_value(fusilier, ("swim", "ticks_per_beat"), 7)
    findings = checks.swim_checks(checks.try_swimming(quick.species.muscles), quick.species.muscles)
    assert any("faster than" in one.text for one in findings if one.severity != GOOD) or any(
        one.severity == FAULT for one in findings
    )
    assert np.isfinite(checks.try_swimming(quick.species.muscles).step_cm)
