"""`subsea-capture validate`: its results and its errors of one line."""

import json

from capture.cli.main import main
from tests.support.commands import refusal


def test_every_species_gets_a_row_of_each_kind(tmp_path, capsys):
    page, report, plots = tmp_path / "page.md", tmp_path / "report.json", tmp_path / "plots"
    words = ["validate", "fusilier", "spotted_eagle_ray", "--plots", str(plots)]
    assert main([*words, "--report", str(page), "--json", str(report)]) == 0
    out = capsys.readouterr().out
    rows = json.loads(report.read_text())["findings"]
    assert {row["subject"] for row in rows} == {"fusilier", "spotted_eagle_ray"}
    assert sum(line.endswith("FAILS") for line in out.splitlines()) == sum(
        row["verdict"] == "fails" for row in rows
    )
    assert page.read_text().count("color:red") == out.count("FAILS")
    assert sorted(path.name for path in plots.iterdir()) == [
        "swimming-speeds.png",
        "swimming-strouhal.png",
        "swimming-waves.png",
    ]


def test_wrong_words_are_errors_of_one_line(tmp_path, capsys):
    mine = tmp_path / "mine.md"
    mine.write_text("# Mine\n")
    for arguments, expected in (
        (["fusiler"], "did you mean 'fusilier'?"),
        (["--report", str(mine)], "exists without the lines"),
        (["--json", str(mine)], "is not a validation report"),
        (["--plots", str(mine)], "mine.md"),
    ):
        assert expected in refusal(main, ["validate", *arguments], capsys)
    assert mine.read_text() == "# Mine\n"
