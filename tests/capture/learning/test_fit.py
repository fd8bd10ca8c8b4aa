"""`subsea-capture fit`: fishes from outlines, and what is refused before a search."""

import numpy as np
import pytest

from capture.cli.main import main
from capture.learning import fit
from capture.learning.lifelike import bent_turn, wave_loss
from subsea.base.system import resource_path
from subsea.base.toml_files import load_toml
from subsea.biomechanics.body import build_body
from subsea.biomechanics.together import swim_course
from subsea.fish.outline_file import read_outline
from subsea.fish.scaffold import fit_scaffold
from subsea.fish.species import Species, load_species, own_species_file
from subsea.repertoire import BASIC_SEGMENTS, read_repertoire
from tests.support.commands import refusal

OUTLINES = resource_path("docs/outlines")


def outline(name):
    return str(OUTLINES / f"{name}.toml")


@pytest.fixture
def home(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    return tmp_path


@pytest.fixture
def drafted(monkeypatch, home):
    """Species that would be searched, without the search; two shipped bodies are tried."""
    found = []

    def learn_plans(plans, jobs, dry_run, force, progress):
        found.extend(plan.task for plan in plans.values())
        return False

    monkeypatch.setattr(fit, "learn_plans", learn_plans)
    monkeypatch.setattr(fit, "muscular_names", lambda: ("blacktip_reef_shark", "fusilier"))
    return found


def test_a_search_begins_with_a_plain_fish_of_the_outline(drafted):
    assert main(["fit", outline("tuna"), "--name", "my_tuna", "--length", "100"]) == 1
    (task,) = drafted
    species = task.species
    assert (species.name, species.form, species.size_cm) == ("My tuna", "fish", (80.0, 110.0))
    assert species.surface == read_outline(OUTLINES / "tuna.toml", 100.0, None)
    assert species.skin.dorsal is None and species.surface.dorsal is None
    assert task.name == "my_tuna" and task.body and task.quick
    # The first guess is better than the scaffold with the gait of one species.
    loss = wave_loss(build_body(species.body), species.swim, "fast", 1)
    assert loss < 20.0
    fusilier = load_species("fusilier")
    plain = fit_scaffold(species.surface)
    assert loss < wave_loss(build_body(plain), fusilier.swim, "fast", 1)


def test_a_slender_fish_begins_with_a_body_that_bends(drafted):
    """At the width of usual bodies a barracuda loses its shape where it bends to turn."""
    assert main(["fit", outline("barracuda"), "--name", "my_barracuda"]) == 1
    (task,) = drafted
    usual = fit_scaffold(task.species.surface)
    assert max(task.species.body.half_widths) < 0.9 * max(usual.half_widths)
    assert swim_course(bent_turn(build_body(task.species.body))) > 20.0


def test_forms_have_what_they_need(drafted, capsys):
    assert main(["fit", outline("flatfish"), "--name", "sole", "--form", "flatfish"]) == 1
    (task,) = drafted
    assert task.species.form == "flatfish" and task.species.surface.pectoral is None
    assert task.species.cruise_height is not None
    # A stiff fish needs no search: its file is written at once.
    for name in ("boxfish", "seahorse"):
        assert main(["fit", outline(name), "--name", f"my_{name}", "--form", "boxfish"]) == 0
        species = load_toml(own_species_file(f"my_{name}"), Species)
        assert species.form == "boxfish" and species.row and species.surface.pectoral
    assert len(drafted) == 1


@pytest.mark.usefixtures("drafted")
def test_what_cannot_be_fitted_is_one_line_before_the_search(capsys, tmp_path):
    def fails(arguments, expected):
        assert expected in refusal(main, ["fit", *arguments], capsys)

    fails([outline("tuna")], "needs the name of its species: --name NAME")
    fails([outline("seahorse"), "--name", "new"], "it has no tail fin")
    fails([outline("tuna"), "--name", "new", "--length", "3", "--mass", "1000"], "cannot weigh")
    fails([outline("tuna"), "--name", "fusilier"], "is that of a shipped species")
    fails(["no_fish"], "no_fish")
    fails(["ribbon_eel", "--name", "new"], "driven by its spine")
    fails(["fusilier", "--name", "new", "--length", "9"], "--length is for outlines")
    fails([outline("tuna"), "--name", "new", "--record", "--dry-run"], "leave out")
    points = np.array(load_toml(OUTLINES / "tuna.toml", fit.OutlinePlan).outline)
    backwards, crossing = tmp_path / "backwards.toml", tmp_path / "crossing.toml"
    backwards.write_text(f"outline = {(points * (-1, 1)).tolist()}\n", encoding="utf-8")
    points[[3, 28]] = points[[28, 3]]
    crossing.write_text(f"outline = {points.tolist()}\n", encoding="utf-8")
    fails([str(backwards), "--name", "new"], "the tail comes first")
    fails([str(crossing), "--name", "new"], "crosses itself")
    assert not own_species_file("new").exists()


def test_a_species_is_fitted_to_its_own_outline(drafted):
    assert main(["fit", "fusilier", "--name", "my_fusilier"]) == 1
    (task,) = drafted
    fusilier = load_species("fusilier")
    assert task.species.surface == fusilier.surface and task.species.skin == fusilier.skin
    assert task.species.name == "My fusilier"
    assert task.species.body != fusilier.body and task.species.turn == fusilier.turn


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "form"),
    [
        ("tuna", "fish"), ("barracuda", "fish"), ("moonfish", "fish"), ("puffer", "fish"),
        ("flatfish", "flatfish"), ("boxfish", "boxfish"), ("seahorse", "boxfish"),
    ],
)  # fmt: skip
def test_seven_outlines_swim_and_turn_to_both_sides(name, form, home):
    words = ["fit", outline(name), "--name", f"my_{name}", "--form", form, "--record"]
    assert main(words) == 0
    repertoire = read_repertoire(home / f"subsea/repertoires/my_{name}.h5")
    found = repertoire.segments
    assert set(BASIC_SEGMENTS) <= set(found)
    speeds = [found[f"swim_{grade}"].speed_cm_s for grade in ("slow", "medium", "fast")]
    assert (np.diff(speeds) > 0).all() and speeds[2] > 0.4 * repertoire.body_length_cm
    for grade, least in (("gradual", 10.0), ("sharp", 60.0)):
        assert found[f"turn_left_{grade}"].turn_deg > least
        assert found[f"turn_right_{grade}"].turn_deg < -least
