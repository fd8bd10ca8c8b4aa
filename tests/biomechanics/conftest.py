import pytest

from subsea.fish.species import Species, load_species, muscular_names


@pytest.fixture(params=muscular_names())
def species(request: pytest.FixtureRequest) -> Species:
    return load_species(request.param)


@pytest.fixture
def fusilier() -> Species:
    return load_species("fusilier")
