from pathlib import Path

import pytest

from subsea.base.toml_files import load_toml
from subsea.fish.species import Species

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(params=("fusilier", "emperor_angelfish"))
def species(request):
    """A fish in Tu's water, whose motor controllers these are."""
    return load_toml(DOCS / f"tu_{request.param}.toml", Species)


@pytest.fixture
def fusilier():
    return load_toml(DOCS / "tu_fusilier.toml", Species)
