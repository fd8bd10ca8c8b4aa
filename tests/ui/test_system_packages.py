"""Error messages suggest the same packages as the set-up installs."""

import re
import tomllib
from pathlib import Path

from subsea.rendering.gl import context
from subsea.ui import monitors as system_packages

SETUP = (Path(__file__).parents[2] / "tools" / "setup.sh").read_text(encoding="utf-8")


def test_the_libraries_are_those_of_the_setup():
    lists = dict(re.findall(r'^([A-Z]+)="(.*)"$', SETUP, re.MULTILINE))
    assert (lists["HEADLESS"], lists["WINDOW"]) == (
        system_packages.HEADLESS,
        system_packages.WINDOW,
    )
    assert context.INSTALL.endswith(system_packages.HEADLESS)
    assert system_packages.INSTALL.startswith(context.INSTALL)


def test_the_workshop_setup_has_every_extra_except_cluster():
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    [line] = re.findall(r'^bench\) groups="(.*?)"', SETUP, re.MULTILINE)
    extras = set(project["project"]["optional-dependencies"])
    assert set(re.findall(r"--extra (\w+)", line)) == extras - {"cluster"}
    assert "--no-dev" in line
