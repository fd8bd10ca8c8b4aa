"""`subsea-capture flat`: its numbers, plots and films, and its errors of one line."""

import av
import numpy as np
import pytest

from capture.cli import flat
from capture.cli.main import main
from capture.flat import films, lessons
from capture.flat.experiments import EXPERIMENTS
from tests.support.commands import refusal


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(lessons, "QUICK", lessons.Effort(1, 8, 1, 4, 1, 1, 1))


def test_the_options_name_every_experiment_and_film():
    assert tuple(EXPERIMENTS) == flat.PARTS and tuple(films.FILMS) == flat.FILMS


@pytest.mark.nightly
def test_plots_and_films_are_written(small, tmp_path, capsys, monkeypatch):
    for name in films.FILMS:
        scene = films.FilmPanel(name, np.zeros((2, 2, 12, 2)))
        monkeypatch.setitem(films.FILMS, name, lambda learner, scene=scene: [scene])
    words = ["flat", "--quick", "--only", "learning", "--only", "swims", "--only", "turns"]
    assert main([*words, "--plots", str(tmp_path), "--films", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert "one frequency: median" in told and "after: the best of 8 tries" in told
    names = ["flat_explosion.mp4", "flat_goal.mp4", "flat_learning.png", "flat_swim.mp4"]
    names += ["flat_swims.png", "flat_turns.png"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    with av.open(tmp_path / "flat_swim.mp4") as film:
        assert len(list(film.decode(video=0))) == 2


@pytest.mark.nightly
def test_all_experiments_are_drawn(small, tmp_path, capsys):
    assert main(["flat", "--quick", "--plots", str(tmp_path), "--films", str(tmp_path)]) == 0
    assert "bound: learned" in capsys.readouterr().out
    assert len(list(tmp_path.glob("flat_*.png"))) == len(EXPERIMENTS)
    assert len(list(tmp_path.glob("flat_*.mp4"))) == len(films.FILMS)


def test_a_scaffold_is_written_and_read(tmp_path, capsys):
    path = tmp_path / "fish.toml"
    assert main(["flat", "--write-scaffold", str(path)]) == 0
    path.write_text(path.read_text().replace("mass = 22.0", "mass = 23.0"))
    assert main(["flat", "--write-scaffold", str(path)]) == 0  # it replaces a scaffold only
    assert "mass = 23.0" not in path.read_text()
    capsys.readouterr()
    path.write_text("points = []\n")
    assert main(["flat", "--write-scaffold", str(path)]) == 2
    assert "exists and is not a scaffold" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--scaffold", "no.toml"], "no.toml: no such file"),
        (["--scaffold", "a.toml", "--write-scaffold", "b.toml"], "give one of the two"),
        (["--only", "swim"], "--only 'swim': unknown choice; did you mean 'swims'?"),
        (["--films", "taken"], "taken: "),
    ],
)
def test_errors_are_one_line(words, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("no folder")
    assert message in refusal(main, ["flat", *words], capsys)
