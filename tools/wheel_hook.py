"""Build hook: what `tools/build_wheel.py` has made, as part of the wheel.

Without it a build makes a pure wheel.
"""

import os
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class ShippedData(BuildHookInterface):
    """Adds the folder in SUBSEA_SHIPPED to the package's data."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add it, and tag the wheel for this Python and this system, whose code it has."""
        if folder := os.environ.get("SUBSEA_SHIPPED"):
            build_data["force_include"][folder] = "subsea/_data"
            build_data["pure_python"] = False
            build_data["infer_tag"] = True
