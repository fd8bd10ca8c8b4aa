"""Python's own switches change nothing: no assert works for its effect, no text is a docstring."""

import ast
import os
import re
import subprocess
import sys

import pytest

from subsea.base.syntax import parse_source
from subsea.base.system import ROOT
from subsea.dive.settings import default_text

QUESTIONS = {"isinstance", "len", "all", "any"}  # calls that only ask
CHILD = """
import sys
from capture.cli import main as capture
from subsea.cli import main as subsea
from subsea.stage.console.commands import described
folder = sys.argv[1]
sea = ["--scenario", "peaceful", "--fish", "3"]
for program, *words in (
    (subsea, "simulate", *sea, "--ticks", "2", "--out", folder + "/sea.h5"),
    (subsea, "film", folder + "/sea.png", *sea, "--seconds", "0.05", "--size", "96x64"),
    (subsea, "list", "scenarios"),
    (subsea, "settings", "--write"),
    (capture, "validate", "clownfish"),
):
    if code := program.main(words):
        raise SystemExit(f"{words}: {code}")
if not all(command["what"] for command in described()):
    raise SystemExit("a command without words")
"""


def test_no_assert_works_for_its_effect():
    faults = []
    for path in [*ROOT.glob("subsea/**/*.py"), *ROOT.glob("capture/**/*.py")]:
        text = path.read_text("utf-8")
        if not re.search(r"\bassert\b", text):
            continue  # it takes a while to look at each node
        for node in ast.walk(parse_source(text)):
            if isinstance(node, ast.Assert):
                faults += [
                    f"{path}:{node.lineno}"
                    for part in ast.walk(node.test)
                    if isinstance(part, ast.NamedExpr)
                    or (isinstance(part, ast.Call) and ast.unparse(part.func) not in QUESTIONS)
                ]
    assert not faults


@pytest.mark.nightly
@pytest.mark.parametrize("switch", ["-OO"])
def test_programs_work_with_the_switch(switch, tmp_path):
    """Their kernels are those of a start without it."""
    done = subprocess.run(
        [sys.executable, switch, "-c", CHILD, str(tmp_path)],
        env=os.environ | {"XDG_CONFIG_HOME": str(tmp_path)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "compiling" not in done.stderr
    assert (tmp_path / "sea.png").exists()
    assert (tmp_path / "subsea/settings.toml").read_text(encoding="utf-8") == default_text()
