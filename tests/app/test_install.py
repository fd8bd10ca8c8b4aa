"""What faults tell to type is what the set-up installs."""

import re
from pathlib import Path

from subsea.app import install
from subsea.render import context

SETUP = (Path(__file__).parents[2] / "tools" / "setup.sh").read_text(encoding="utf-8")


def test_the_libraries_are_those_of_the_setup():
    lists = dict(re.findall(r'^([A-Z]+)="(.*)"$', SETUP, re.MULTILINE))
    assert (lists["HEADLESS"], lists["WINDOW"]) == (install.HEADLESS, install.WINDOW)
    assert context.INSTALL.endswith(install.HEADLESS)
    assert install.INSTALL.startswith(context.INSTALL)
