"""Nodes of the fish known in closed form."""

import pytest


@pytest.fixture(scope="session")
def known_repertoire_nodes(known_repertoire):
    return known_repertoire.rest_nodes
