"""The crowns where fishes feed are those of the drawn meshes."""

import numpy as np
import pytest

from subsea.habitat.sites import CROWN_AT, CROWNS, OFFERS
from subsea.habitat.terrain import VARIANTS
from subsea.rendering.reef.coral_kinds import forms

TOP = 97.0  # percentile of the heights of vertices in a ring: its crown, without single tips


@pytest.mark.parametrize("kind", OFFERS)
def test_the_crown_of_a_kind_is_that_of_its_meshes(kind):
    _, least, most = OFFERS[kind]
    for finest, *_ in forms([(kind, variant) for variant in range(VARIANTS)]):
        away = np.hypot(finest.place[:, 0], finest.place[:, 1])
        for at, height in zip(CROWN_AT, CROWNS[kind], strict=True):
            ring = np.abs(away - at) < 0.075
            if least <= at <= most and ring.sum() > 20:
                top = np.percentile(finest.place[ring, 2], TOP)
                assert top == pytest.approx(
                    height, abs=0.25 if kind in ("pipes", "finger") else 0.13
                )
