"""What is told of a fish that is being built: true of shipped ones, and of spoilt ones."""

import numpy as np
import pytest

from subsea.fish.editing import checks
from subsea.fish.editing import draft as drafts
from subsea.fish.editing.checks import BAD, GOOD, MIND
from subsea.fish.species import load_species, muscular_names, species_file, species_names


@pytest.fixture(scope="module")
def fusilier():
    return drafts.read(species_file("fusilier"))


def said(remarks, word):
    """The only remark that has a word in it."""
    found = [remark for remark in remarks if word in remark.text]
    assert len(found) == 1, remarks
    return found[0]


@pytest.mark.parametrize("name", species_names())
def test_shipped_species_stand_up_to_it(name):
    remarks = checks.standing(load_species(name))
    assert remarks and not [one for one in remarks if one.mark == BAD]
    minded = [one for one in remarks if one.mark == MIND]
    assert len(minded) <= (name == "emperor_angelfish")  # which is light for its size


@pytest.mark.parametrize("name", muscular_names())
def test_shipped_species_swim_turn_and_keep_their_shape(name):
    muscles = load_species(name).muscles
    swum = checks.tried(muscles)
    assert {one.mark for one in checks.told(swum, muscles)} == {GOOD}
    assert 0.65 <= swum.strain[0] < 1 < swum.strain[1] <= 1.4
    assert swum.turned_deg == pytest.approx(muscles.turn.sharp, abs=2)


def test_speed_is_that_of_the_documentation():
    swum = checks.tried(load_species("fusilier").muscles)
    assert swum.per_beat == pytest.approx(0.462, abs=0.003)
    assert swum.sweep == pytest.approx(0.192, abs=0.003)
    assert swum.speed_bl_s == pytest.approx(0.999, abs=0.01)


def with_body(draft, **keys):
    return drafts.changed_all(draft, {("body", key): value for key, value in keys.items()})


def test_each_fault_is_named_with_what_to_do(fusilier):
    body = fusilier.content["body"]

    def of(draft):
        return checks.standing(draft.species)

    tall = [*body["half_heights"]]
    tall[1] *= 3.2
    out = said(of(with_body(fusilier, half_heights=tall)), "Ring 2")
    assert out.mark == MIND and "Lower it" in out.text
    heavy = said(of(drafts.as_heavy(fusilier, 220.0)), "sink")
    assert heavy.mark == MIND and "Neutral" in heavy.text
    level = drafts.as_heavy(fusilier, checks.displaced_cm3(fusilier.species))
    assert said(of(level), "buoyant").mark == GOOD
    front = with_body(fusilier, masses=[20.0, 9.0, 3.0, 1.5, 1.5, 1.5, 1.5])
    assert said(of(front), "forward").mark == MIND
    thin = drafts.changed(fusilier, ("surface", "width", 3), [0.1, -0.01])
    assert said(of(thin), "no width").mark == BAD
    sunk = [[x, 0.4 * y] for x, y in fusilier.content["surface"]["dorsal"]["edge"]]
    assert (
        said(
            of(drafts.changed(fusilier, ("surface", "dorsal", "edge"), sunk)), "fin lies inside"
        ).mark
        == MIND
    )


def test_a_hull_that_is_folded_is_told():
    body = checks.build_body(load_species("fusilier").body)
    assert said(checks._faces(body), "78 faces").mark == GOOD
    folded = body.rest.copy()
    folded[[9, 10]], folded[[11, 12]] = folded[[12, 11]], folded[[10, 9]]  # ring 3 upside down
    remark = said(checks._faces(body._replace(rest=folded)), "folded")
    assert remark.mark == BAD and "ring 2" in remark.text


def test_a_body_that_loses_its_shape_is_named_with_the_place(fusilier):
    wild = drafts.changed(fusilier, ("swim", "contraction"), [0.6, 0.6])
    wild = with_body(wild, half_widths=[0.4, 0.5, 0.5, 0.25, 0.25])
    swum = checks.tried(wild.species.muscles)
    assert not swum.sound
    (remark,) = checks.told(swum, wild.species.muscles)
    assert remark.mark == BAD and "ring" in remark.text


def test_one_that_hardly_moves_is_sent_to_learn(fusilier):
    weak = drafts.changed(fusilier, ("swim", "contraction"), [0.05, 0.05])
    muscles = weak.species.muscles
    remarks = checks.told(checks.tried(muscles), muscles)
    assert said(remarks, "slowly").mark == MIND and "Learn" in said(remarks, "slowly").text
    assert said(remarks, "sweeps little").mark == MIND
    assert said(remarks, "sharp turn").mark == MIND


def test_one_too_quick_for_muscles_is_told(fusilier):
    quick = drafts.changed(fusilier, ("swim", "ticks_per_beat"), 7)
    remarks = checks.told(checks.tried(quick.species.muscles), quick.species.muscles)
    assert any("faster than" in one.text for one in remarks if one.mark != GOOD) or any(
        one.mark == BAD for one in remarks
    )
    assert np.isfinite(checks.tried(quick.species.muscles).step_cm)
