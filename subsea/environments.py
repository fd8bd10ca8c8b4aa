"""The environments for learning, under the name by which programs import them."""

import sys

from subsea.base.registry import LIBRARIES, load_named

sys.modules[__name__] = load_named(LIBRARIES, "environments", "library")
