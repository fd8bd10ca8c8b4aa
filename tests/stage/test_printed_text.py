"""Titles and captions of files reach the terminal without escapes and line breaks."""

import json

import pytest

from subsea.cli.main import main
from subsea.lab.comparison import RecordGroup, comparison_table
from subsea.scenario.load import own_scenarios, scenario_file
from tests.support import theatre_samples as samples

ODD = r"My \u001b[2J\n\u0007\u202Ebay"
CLEAN = "My ?[2J???bay"
SHOW = f'title = "{ODD}"\n[[item]]\nscenario = "peaceful"\ncaption = "{ODD}"\n'
THEATRE = (
    f'title = "{ODD}"\n[[window]]\nname = "a"\nsize = [64, 48]\nmonitor = "{ODD}"\n'
    '[[channel]]\nname = "a"\nwindow = "a"\ndome = {}\n'
)
CONFIGURATION = samples.sgct(meta={"name": json.loads(f'"{ODD}"')}) | {"a\x1b[2J\n": 1}


@pytest.mark.parametrize(
    ("words", "name", "text", "seen"),
    [
        ("show", "show.toml", SHOW, 2),
        ("theatre", "room.toml", THEATRE, 1),
        ("theatre", "room.json", json.dumps(CONFIGURATION), 0),
        ("list scenarios", "subsea/scenarios/odd.toml", None, 1),
    ],
)
def test_text_of_files_is_cleaned(words, name, text, seen, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    if text is None:
        assert path.parent == own_scenarios()
        text = scenario_file("peaceful").read_text().replace("Peaceful bay", ODD)
    path.write_text(text)
    main([*words.split(), *([] if words.startswith("list") else [str(path)])])
    captured = capsys.readouterr()
    assert captured.out.count(CLEAN) == seen
    assert all(c.isprintable() or c == "\n" for c in captured.out + captured.err)
    assert "My" not in [line[:2] for line in captured.out.splitlines() if CLEAN not in line]


def test_labels_of_records_are_one_line_each():
    group = RecordGroup(json.loads(f'"{ODD}"'), *[[]] * (len(RecordGroup._fields) - 1))
    assert all(line.isprintable() for line in comparison_table([group]))
