"""Writing a new theatre: the file reads back, works, and replaces nothing."""

import numpy as np
import pytest
from PIL import Image

from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.stage.plan import NewTheatre, write_theatre
from subsea.stage.setup import set_up_theatre
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.measures import KINDS
from tests.support.daily import only

SMALL = "--across", "640", "--down", "480"


def run(capsys, *words):
    """Exit code, output and lines of errors of `subsea theatre`."""
    code = main(["theatre", *map(str, words)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err.splitlines()


@pytest.mark.parametrize("kind", only(["wall", "mirror"], KINDS))
def test_a_new_theatre_works_as_it_is_written(tmp_path, capsys, kind):
    path = tmp_path / "new.toml"
    code, out, err = run(capsys, "--new", kind, "--out", path, *SMALL)
    assert (code, err) == (0, [])
    assert "does not work" not in out
    assert "1. Fix each projector" in out
    theatre, _ = load_theatre(str(path))
    setup = set_up_theatre(str(path))
    assert len(setup.rig.patches) == len(theatre.channel) == len(theatre.room.projectors)
    assert f"subsea theatre --new {kind} " in path.read_text()
    again = tmp_path / "again.toml"
    command = path.read_text().splitlines()[1].removeprefix("#   subsea theatre ").split()
    assert run(capsys, *command, "--out", again)[0] == 0
    assert again.read_text().replace("again-", "new-") == path.read_text()
    assert np.ptp(np.asarray(Image.open(tmp_path / "new.png"))) > 100


@pytest.mark.nightly
def test_each_projector_may_have_a_computer(tmp_path, capsys):
    path = tmp_path / "new.toml"
    code, out, _ = run(capsys, "--new", "curved", "--computers", "--out", path, *SMALL)
    assert code == 0
    theatre, _ = load_theatre(str(path))
    assert theatre.nodes == ("left", "middle", "right")
    assert theatre.cluster.master == "middle"
    assert "throw ratios of the lenses, distance over width of the picture: " in out
    assert "with left, right" in out
    assert len(set_up_theatre(str(path), node="left").windows) == 1


def test_questions_are_asked_on_a_terminal_only(tmp_path, capsys):
    wanted = NewTheatre("", {}, tmp_path / "new")
    with pytest.raises(UserError, match="--new: expected a kind of theatre: wall, curved,"):
        write_theatre(wanted, asks=lambda: False)
    answers = iter(["wall", "2"])
    assert write_theatre(wanted, lambda question: next(answers, ""), lambda: True) == 0
    assert len(load_theatre(str(tmp_path / "new.toml"))[0].channel) == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--new", "wall", "--projectors", "0"],
         "argument --projectors: '0': expected a whole number from 1 to 32"),
        (["--new", "ball"], "unknown kind of theatre 'ball'; did you mean 'wall'?"),
        (["--new", "wall", "--radius", "50"], "--radius is not for a wall, expected"),
        (["--new", "dome", "--throw", "9"], "--throw 9 lights too little of its part of the dome"),
        (["--new", "dome", "--projectors", "1", "--computers"], "--computers needs two projectors"),
        (["cave", "--new", "wall"], "theatre: --new writes to --out FILE, drop 'cave'"),
    ],
)  # fmt: skip
def test_bad_input_gets_one_line_and_writes_nothing(tmp_path, capsys, words, message):
    code, _, err = run(capsys, *words, "--out", tmp_path / "new.toml")
    assert code == 2
    assert len(err) == 1
    assert message in err[0]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "theatre: expected a name or a file, or --new"),
        (["--new", "wall"], "theatre: --new needs --out FILE.toml"),
        (["cave", "--radius", "50"], "--radius needs --new too"),
    ],
)
def test_options_that_do_not_fit_together_are_refused(capsys, words, message):
    assert run(capsys, *words)[::2] == (2, [f"subsea: {message}"])


def test_nothing_is_replaced_unless_forced(tmp_path, capsys):
    path = tmp_path / "new.toml"
    for name in ("new.toml", "new-left.data", "new.png"):
        (tmp_path / name).write_text("mine")
        code, _, err = run(capsys, "--new", "curved", "--out", path, *SMALL)
        assert (code, len(err)) == (2, 1)
        assert name in err[0]
        assert (tmp_path / name).read_text() == "mine"
        if name == "new.png":
            assert run(capsys, "--new", "curved", "--force", "--out", path, *SMALL)[0] == 0
            assert (tmp_path / name).read_bytes() != b"mine"
        (tmp_path / name).unlink()


@pytest.mark.parametrize("name", ["cave", "dome", "wide", "equirectangular", "three-projectors"])
def test_the_room_of_any_theatre_can_be_drawn(tmp_path, capsys, name):
    picture = tmp_path / "room.png"
    code, out, _ = run(capsys, name, "--picture", picture)
    assert code == 0
    assert out.endswith(f"the room: {picture}\n")
    assert np.ptp(np.asarray(Image.open(picture))) > 100
