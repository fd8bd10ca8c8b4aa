"""Checks of an edited fish: shipped species pass, spoilt ones are reported."""

import numpy as np
import pytest

from subsea.fish.measured import load_measured
from subsea.fish.species import load_species, muscular_names, species_file, species_names
from subsea.studio import checks
from subsea.studio.checks import FAULT, GOOD, WARNING
from subsea.studio.draft import EditError, read_draft, with_value, with_values
from subsea.studio.outline import with_mass


@pytest.fixture(scope="module")
def fusilier():
    return read_draft(species_file("fusilier"))


def said(findings, word):
    """The only finding that has a word in it."""
    found = [finding for finding in findings if word in finding.text]
    assert len(found) == 1, findings
    return found[0]


def test_static_checks_of_shipped_species_find_no_fault():
    for name in species_names():
        findings = checks.static_checks(load_species(name))
        assert findings and {one.severity for one in findings} == {GOOD}, name


@pytest.mark.parametrize(
    "name",
    [
        name
        if name in ("fusilier", "moon_wrasse")
        else pytest.param(name, marks=pytest.mark.nightly)
        for name in muscular_names()
    ],
)
def test_shipped_species_swim_turn_and_keep_their_shape(name):
    swim = checks.try_swimming(load_species(name).muscles)
    assert {one.severity for one in checks.swim_checks(swim)} == {GOOD}
    assert 0.65 <= swim.strain[0] < 1 < swim.strain[1] <= 1.4
    low, high = load_measured().species[name].amplitude.range
    assert low <= swim.sweep <= high
    turned = swim.motion.segments["turn_left_gradual"].turn_deg
    assert 15.0 < turned < 45.0  # a circle of 8 to 24 beats
    assert {"swim_slow", "turn_right_sharp"} < set(swim.motion.segments)
    if name == "fusilier":  # the numbers of the documentation
        assert swim.sweep == pytest.approx(0.172, abs=0.003)
        fast = swim.motion.segments["swim_fast"]
        assert fast.speed_cm_s / swim.motion.length_cm == pytest.approx(0.983, abs=0.01)


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
    wrasse = read_draft(species_file("moon_wrasse"))
    level = with_mass(wrasse, checks.displaced_cm3(wrasse.species))
    assert said(of(level), "buoyant").severity == GOOD
    for share, words in ((0.88, "12% lighter"), (1.25, "25% heavier")):
        off = with_mass(wrasse, share * checks.displaced_cm3(wrasse.species))
        assert said(of(off), "displaced").text.startswith(f"It is {words} than the water")
        assert not [one for one in of(off) if "buoyant" in one.text]
        step = said(of(off), "step")  # the tail of a light fish is too light for its stiffness
        assert step.severity == (WARNING if share < 1.0 else GOOD)
        assert ("Make the tail heavier" in step.text) == (share < 1.0)
    with pytest.raises(EditError, match=r"masses\[6\].*raise the mass, or lower stiffness"):
        with_mass(wrasse, 0.7 * checks.displaced_cm3(wrasse.species))
    front = with_body(fusilier, masses=[20.0, 14.0, 4.0, 4.0, 2.0, 2.0, 2.0])
    assert said(of(front), "forward").severity == WARNING
    thin = with_value(fusilier, ("surface", "width", 3), [0.1, -0.01])
    assert said(of(thin), "no width").severity == FAULT
    sunk = [[x, 0.4 * y] for x, y in fusilier.content["surface"]["dorsal"]["edge"]]
    inside = with_value(fusilier, ("surface", "dorsal", "edge"), sunk)
    assert said(of(inside), "fin lies inside").severity == WARNING


def test_a_folded_hull_is_reported():
    body = checks.build_body(load_species("fusilier").body)
    assert said([checks.check_faces(body)], "78 faces").severity == GOOD
    folded = body.rest.copy()
    folded[[9, 10]], folded[[11, 12]] = folded[[12, 11]], folded[[10, 9]]  # ring 3 upside down
    finding = said([checks.check_faces(body._replace(rest=folded))], "folded")
    assert finding.severity == FAULT and "ring 2" in finding.text


def test_a_body_that_loses_its_shape_is_named_with_the_place(fusilier):
    wild = with_value(fusilier, ("swim", "contraction"), [0.6, 0.6])
    wild = with_body(wild, half_widths=[0.4, 0.5, 0.5, 0.25, 0.25])
    swim = checks.try_swimming(wild.species.muscles)
    assert not swim.sound
    (finding,) = checks.swim_checks(swim)
    assert finding.severity == FAULT and "ring" in finding.text


@pytest.mark.nightly
def test_a_slow_fish_is_advised_to_learn(fusilier):
    weak = with_value(fusilier, ("swim", "contraction"), [0.05, 0.05])
    muscles = weak.species.muscles
    findings = checks.swim_checks(checks.try_swimming(muscles))
    assert said(findings, "slowly").severity == WARNING and "Learn" in said(findings, "slowly").text
    assert said(findings, "sweeps little").severity == WARNING


@pytest.mark.nightly
def test_advice_for_a_narrow_tail_stalk_is_borne_out():
    """Fewer contractions are advised only if they keep the fish steady, else another body."""
    wrasse = read_draft(species_file("moon_wrasse"))
    widths = wrasse.content["body"]["half_widths"]
    narrow = with_body(wrasse, half_widths=[*widths[:4], 0.5 * widths[4]])
    swim = checks.try_swimming(narrow.species.muscles)
    (finding,) = checks.swim_checks(swim)
    assert finding.text.endswith("less: 60% of the present contractions are enough.")
    contractions = [round(0.6 * c, 3) for c in narrow.content["swim"]["contraction"]]
    calm = with_value(narrow, ("swim", "contraction"), contractions).species.muscles
    assert checks._is_steady(calm.body, calm.swim, "fast")
    heights = wrasse.content["body"]["half_heights"]
    thin = {"half_heights": [*heights[:4], 0.3 * heights[4]]}
    thin = with_body(wrasse, half_widths=[*widths[:4], 0.3 * widths[4]], **thin)
    assert (
        "species like it" in checks.swim_checks(checks.try_swimming(thin.species.muscles))[0].text
    )


def test_a_heavy_body_is_not_made_heavier_to_be_stable(fusilier):
    body = checks.build_body(fusilier.species.body)
    stiff = body._replace(stiffness=1.3 * body.stiffness)
    light, heavy = (checks._material(stiff, light, False).text for light in (True, False))
    assert "heavier, or the units softer" in light
    assert heavy.endswith("Make the units softer.")


def test_a_threshold_that_is_met_is_not_a_warning(fusilier):
    """It said `0.02 lengths or more (now 0.02)`."""
    body = fusilier.species.body
    for front in np.linspace(0.0, 40.0, 400):
        masses = (body.masses[0], body.masses[1] + front, *body.masses[2:])
        moved = checks.structs.replace(body, masses=masses)
        for severity, text in checks._buoyancy(moved, moved.mass):
            assert "(now 0.02)" not in text, severity


@pytest.mark.nightly
def test_turning_muscles_that_contract_too_little_or_too_much_are_reported(fusilier):
    for contraction, severity, advice in ((0.02, WARNING, "more"), (0.6, FAULT, "less")):
        turning = with_value(fusilier, ("turn", "gradual"), [contraction] * 2)
        muscles = turning.species.muscles
        found = said(checks.swim_checks(checks.try_swimming(muscles)), "gradual turn")
        assert found.severity == severity
        assert f"Contract the turning muscles {advice}." in found.text


@pytest.mark.nightly
def test_a_beat_too_fast_for_muscles_is_reported(fusilier):
    muscles = with_value(fusilier, ("swim", "ticks_per_beat"), 7).species.muscles
    swim = checks.try_swimming(muscles)
    assert np.isfinite(swim.step_cm)
    assert any(
        one.severity == FAULT or (one.severity == WARNING and "faster than" in one.text)
        for one in checks.swim_checks(swim)
    )
