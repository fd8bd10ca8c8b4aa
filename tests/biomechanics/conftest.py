import pytest

from subsea.species import Species, load_species


@pytest.fixture(params=["fusilier", "emperor_angelfish"])
def species(request: pytest.FixtureRequest) -> Species:
    return load_species(request.param)


@pytest.fixture
def fusilier() -> Species:
    return load_species("fusilier")
