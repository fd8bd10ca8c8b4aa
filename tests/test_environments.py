"""Programs import the environments for learning by a short name."""

import subsea.environments
from subsea.lab import environments


def test_the_short_name_is_the_package_itself():
    assert subsea.environments is environments
