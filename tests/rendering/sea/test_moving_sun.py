"""The shade on sand and stone in a moving day is that of the hour."""

from dataclasses import replace

import numpy as np
import pytest
from msgspec import structs

from subsea.habitat.stone import SUNS, shares_of_suns, sun_at, suns_of_day
from subsea.rendering.output.quality import PRESETS
from tests.support.daily import only

ROCKS = np.array(
    [[30.0, 110.0, -300.0, 70.0, 60.0, 80.0, 0.5], [-130.0, 160.0, -180.0, 90.0, 50.0, 30.0, 0.0]]
)
PLAIN = replace(PRESETS["low"], snow=0, shafts=0, shadows=False)


def test_the_sun_is_shared_between_the_two_nearest_of_its_course():
    for k, sun in enumerate(suns_of_day()):
        np.testing.assert_allclose(shares_of_suns(sun), np.eye(SUNS)[k], atol=1e-6)
    for hour in np.arange(0.0, 24.0, 0.25):
        shares = shares_of_suns(sun_at(hour)[0])
        assert shares.sum() == pytest.approx(1.0) and (shares > 0.0).sum() <= 2
    day = np.array([shares_of_suns(sun_at(hour)[0]) for hour in np.arange(6.0, 18.1, 0.5)])
    assert (np.diff(day @ np.arange(SUNS)) > 0.0).all()


@pytest.mark.nightly
@pytest.mark.parametrize("hour", only([9.0, 23.0], [9.0, 11.2, 15.0, 23.0]))
def test_an_hour_looks_alike_whether_the_day_came_there_or_began_there(
    drawn, scene, make_packet, hour
):
    packet = make_packet([], eye=(-60.0, -220.0, -190.0), heading=1.3, pitch=-0.3)

    def seen(start, day_minutes, now):
        """The place in a day that began at `start` and takes `day_minutes`; 0: it stands still."""
        water = structs.replace(scene.water, hour=start, day_minutes=day_minutes)
        sea = replace(scene, rocks=ROCKS, water=water)
        return drawn(replace(packet, hour=now), scene=sea, quality=PLAIN).astype(float)

    began, came, stale = seen(hour, 0.0, None), seen(13.0, 10.0, hour), seen(13.0, 0.0, hour)
    assert np.abs(came - began).mean() < 0.3
    assert np.abs(came - began).mean() < 0.25 * np.abs(stale - began).mean()
