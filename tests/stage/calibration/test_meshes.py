"""The meshes of measured projectors, and how far they are from what was planned."""

import numpy as np
import pytest

from subsea.stage.calibration.lit_theatre import lit_theatre
from subsea.stage.calibration.meshes import away_from_plan, planned_projector


def test_a_projector_elsewhere_is_away_from_its_plan(wall):
    lit = lit_theatre(str(wall.path))
    channel, surface = lit.channels[0], lit.surfaces[0]
    planned = planned_projector(surface, channel)
    assert away_from_plan(planned, channel) == pytest.approx(0.0, abs=1e-6)
    beside = planned._replace(nodes=planned.nodes + [1.0, 0.0])  # by the width of the picture
    width, height = (np.linalg.norm(side) for side in (channel.screen.along, channel.screen.up))
    expected = width / np.hypot(width, height)
    assert away_from_plan(beside, channel) == pytest.approx(expected, rel=1e-3)
