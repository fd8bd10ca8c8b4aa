import numpy as np
import pytest

from capture.inspection.simulated import measure_simulated, replay
from capture.recording.record import motion_of


@pytest.mark.nightly
def test_every_measure_keeps_its_limit(repertoire, species):
    report = list(measure_simulated(motion_of(species), repertoire))
    # The cost depends on what else this machine does; everything else must hold anywhere.
    short = [m for m in report if not m.passed and "µs" not in m.value]
    assert not short
    assert len(report) > 20


def test_a_cycle_can_be_replayed_without_end(repertoire):
    swim = repertoire.segments["swim_fast"]
    way = replay(swim, np.zeros(3), np.eye(3), 40)[len(swim.nodes) - 1 :: len(swim.nodes)]
    strides = np.diff(way.mean(axis=1), axis=0)
    np.testing.assert_allclose(strides, strides[:1].repeat(len(strides), axis=0), atol=1e-4)
