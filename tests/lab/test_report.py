"""`subsea study`: reading records, the table, JSON and plots."""

import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from PIL import Image

from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.fish.species import load_species, species_names
from subsea.lab import plots
from subsea.lab import report as study
from subsea.media.record import COORDINATES, DIMENSIONS, FIELDS, outline, read_record

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    out = tmp_path_factory.mktemp("study") / "run.h5"
    assert main(["simulate", "--ticks", "40", "--fish", "12", "--out", str(out)]) == 0
    return out


@pytest.fixture
def damaged(record, tmp_path):
    """A copy to spoil."""
    copy = tmp_path / "copy.h5"
    copy.write_bytes(record.read_bytes())
    return copy


def test_reading_returns_the_written_record(record):
    read = read_record(record)
    with h5py.File(record) as file:
        for name in ("position", "intention", "mental_state", "alive", "leader", "male", "length"):
            assert np.array_equal(getattr(read, name), file[f"fish/{name}"][()])
        assert np.array_equal(read.plankton, file["plankton/count"])
        assert np.array_equal(read.heights, file["sea/heights"])
    assert read.intention_names[:7] == [
        "avoid", "escape", "school", "eat", "mate", "leave", "wander",
    ]  # fmt: skip
    assert read.alarmed == 0.5


@pytest.mark.nightly
def test_the_command_prints_writes_and_draws(record, tmp_path, capsys):
    out, report = tmp_path / "plots", tmp_path / "report.json"
    assert main(["study", str(record), "--out", str(out), "--json", str(report)]) == 0
    text = capsys.readouterr().out
    found = json.loads(report.read_text())
    assert text.startswith("40 ticks (1.32 s) of 12 fishes")
    assert f"{found['sea']['least_clearance_cm']:.1f} cm from the" in text
    for name, number in found["species"].items():
        assert f"{number} {name}" in text
        shares = found["minds"]["time_budget"][name].values()
        assert sum(shares) == pytest.approx(1.0 if number else 0.0, abs=0.001)
    drawn = {path.stem: np.asarray(Image.open(path)) for path in out.iterdir()}
    assert {"time_budget", "minds", "paths", "clearance", "schools"} == set(drawn)
    assert all(picture.std() > 5 and picture.shape[1] >= 600 for picture in drawn.values())


def test_one_tick_of_one_fish_can_be_studied(tmp_path, capsys):
    """One tick of one fish."""
    out = tmp_path / "one.h5"
    assert main(["simulate", "--ticks", "1", "--fish", "1", "--out", str(out)]) == 0
    assert main(["study", str(out), "--out", str(tmp_path / "plots")]) == 0
    recorded, studied = capsys.readouterr().out.splitlines()[:2]
    assert recorded == f"{out}: 1 tick of 1 fish"
    assert studied.startswith("1 tick (0.033 s) of 1 fish, seed")


def replaced(name, value):
    """A function that replaces a dataset of a file."""

    def spoil(file):
        del file[name]
        file[name] = value

    return spoil


def entry(name, place, value):
    return lambda file: file[name].__setitem__(place, value)


def attribute(name, value):
    return lambda file: file.attrs.__setitem__(name, value)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (replaced("fish/position", np.zeros((40, 12, 3), "S3")), "fish/position: expected"),
        (
            replaced("fish/alive", np.ones((39, 12), bool)),
            "fish/alive: shape 39×12, expected 40×12",
        ),
        (
            entry("fish/snout", (3, 4, 1), np.nan),
            "fish/snout: contains numbers that are not finite",
        ),
        (entry("fish/intention", (5, 5), 200), "fish/intention: code 200 has no name"),
        (entry("fish/leader", (5, 5), 12), "fish/leader: expected fishes from 0 to 11"),
        (entry("time", 5, 99.0), "time: expected increasing times"),
        (attribute("version", 1), "version 1 of the format, expected 2"),
        (attribute("format", np.bytes_(b"subsea-repertoire")), "not a record of a simulation"),
        (attribute("kind_names", 3), "'kind_names' is not a row of words"),
        (attribute("tick_s", np.nan), "'tick_s' is nan"),
        (replaced("sea/heights", h5py.ExternalLink("other.h5", "/x")), "sea/heights: missing"),
        (replaced("time", np.arange(1, 2_000_001.0)), "are too many for one study"),
    ],
)
def test_a_damaged_record_is_one_line(damaged, spoil, words, capsys):
    with h5py.File(damaged, "r+") as file:
        spoil(file)
    assert main(["study", str(damaged)]) == 2
    err = capsys.readouterr().err
    assert words in err and str(damaged) in err
    assert len(err.splitlines()) == 1


def test_a_foreign_file_is_one_line(damaged, capsys):
    path, whole = damaged, damaged.read_bytes()
    repertoire = (DOCS.parent / "repertoires" / "fusilier.h5").read_bytes()
    half = whole[: len(whole) // 2]
    for content in (b"", b"no HDF5", b"\x89HDF\r\n\x1a\n" + bytes(100), half, repertoire):
        path.write_bytes(content)
        assert main(["study", str(path)]) == 2
        err = capsys.readouterr().err
        assert len(err.splitlines()) == 1
    assert "not a record of a simulation" in err  # the repertoire


def test_no_room_for_results_is_said_before_the_work(record, tmp_path, capsys):
    blocked = tmp_path / "file"
    blocked.write_text("")
    for option in (["--out", str(blocked / "plots")], ["--json", str(blocked / "x.json")]):
        assert main(["study", str(record), *option]) == 2
        out = capsys.readouterr()
        assert not out.out and len(out.err.splitlines()) == 1


def test_a_result_never_takes_the_place_of_the_record(damaged, tmp_path, monkeypatch, capsys):
    before = damaged.read_bytes()
    monkeypatch.chdir(tmp_path)
    drawn = tmp_path / "plots" / "minds.png"
    drawn.parent.mkdir()
    drawn.write_bytes(before)
    for options in (
        [str(damaged), "--json", f"../{tmp_path.name}/copy.h5"],
        [str(drawn), "--out", "plots"],
        [str(damaged), "--out", "plots", "--json", "plots/paths.png"],
    ):
        assert main(["study", *options]) == 2
        out = capsys.readouterr()
        assert not out.out and len(out.err.splitlines()) == 1
        assert "too, expected another name" in out.err
    assert damaged.read_bytes() == drawn.read_bytes() == before
    assert list(drawn.parent.iterdir()) == [drawn]


@pytest.mark.nightly
@pytest.mark.parametrize("when", ["measuring", "drawing"])
def test_ctrl_c_leaves_no_result(record, tmp_path, monkeypatch, capsys, when):
    """Ctrl-C in the middle of a measure or plot takes effect after it."""
    done = []

    def disturbed(*given, **named):
        signal.raise_signal(signal.SIGINT)
        done.append(when)

    if when == "measuring":
        monkeypatch.setattr(study, "_minds", disturbed)
    else:
        monkeypatch.setitem(plots.RECORD_PLOTS, "paths", disturbed)
    places = ["--out", str(tmp_path / "plots"), "--json", str(tmp_path / "report.json")]
    assert main(["study", str(record), *places]) == 130
    assert done == [when]
    assert capsys.readouterr().err == "subsea: interrupted\n"
    assert not list(tmp_path.iterdir())


def test_without_matplotlib_the_table_works_and_plots_are_one_line(record, tmp_path):
    program = (
        "import sys; sys.modules['matplotlib'] = None; from subsea.cli.main import main; "
        f"a = main(['study', {str(record)!r}]); "
        f"b = main(['study', {str(record)!r}, '--out', {str(tmp_path / 'plots')!r}]); print(a, b)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "0 2"
    assert done.stderr.strip() == "subsea: plots need matplotlib: run `make bench`"
    assert not (tmp_path / "plots").exists()


@pytest.mark.parametrize("name", species_names())
def test_outlines_are_those_of_the_species(name):
    species = load_species(name)
    width, height = outline(species.surface)
    assert (width >= 0).all() and (height >= 0).all()
    wing = species.surface.wing
    widest = wing.span if wing else max(w for _, w in species.surface.width)
    # A wing's tip may lie between two of the thirteen places.
    assert (0.7 if wing else 0.9) * widest < width.max() <= 1.001 * widest
    # The tail fin may be as tall as the body.
    assert 2 * height[:9].max() == pytest.approx(species.surface.depth, rel=0.12)


def test_a_scenario_of_any_length_fits_beside_the_data(record):
    """The text is an attribute; compact attributes of HDF5 hold at most 64 KB."""
    with h5py.File(record) as file:
        assert file.attrs.get_id("scenario").dtype.hasobject


def test_the_documentation_lists_every_dataset():
    page = (DOCS / "reference" / "records.md").read_text(encoding="utf-8")
    documented = FIELDS | COORDINATES
    for name, field in documented.items():
        shape = " × ".join(field.dimensions)
        kind = "text" if field.type is str else np.dtype(field.type).name
        cells = (f"`{name}`", shape, kind, field.unit, field.meaning)
        assert f"| {' | '.join(cells)} |" in page
    listed = re.findall(r"^\| `[a-z_]+(/[a-z_]+)?` \| (\w+)[^|]* \|", page, re.M)
    assert sum(first in DIMENSIONS for _, first in listed) == len(documented)


def test_the_example_of_the_documentation_runs(record, monkeypatch, capsys):
    example = re.search(r"```python\n(.*?)```", (DOCS / "how-to" / "study.md").read_text(), re.S)
    monkeypatch.chdir(record.parent)
    exec(compile(example[1], "docs/how-to/study.md", "exec"), {})
    first, second = capsys.readouterr().out.splitlines()
    intentions = read_record(record).intention_names
    assert any(name in first for name in intentions) and first.endswith("fish-seconds")
    assert second.endswith("cm")


def test_a_user_error_names_a_missing_file():
    with pytest.raises(UserError, match="no such file"):
        read_record(Path("nowhere.h5"))
