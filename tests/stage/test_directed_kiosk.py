"""A kiosk that repeats a directed scene until a visitor comes."""

from contextlib import closing

import numpy as np
import pytest

from subsea.dive.captions import caption_of
from subsea.dive.settings import AttractSettings, Settings
from subsea.stage.parts import KioskPart
from subsea.ui.dive import Dive
from subsea.world.world import TICK_S
from tests.support.scenes import scene
from tests.support.windows import dive_options

AFTER_S, END_S = 1.5, 3.0
CUES = (
    "camera = { position_cm = [-480.0, -200.0, -250.0], look_at_cm = [-300.0, 0.0, -250.0], "
    "over_s = 0.0 }\ncaption = 'Again.'",
    f"at_s = {END_S}\nend = true",
)


@pytest.mark.nightly
def test_the_scene_restarts_at_its_end_and_when_a_visitor_has_left(display, user, coarse, tmp_path):
    settings = Settings(attract=AttractSettings(after_min=AFTER_S / 60.0))
    with closing(
        Dive(
            dive_options(
                scene(tmp_path, *CUES), (320, 240), coarse,
                settings=settings, parts=[KioskPart()], tour="directed",
            )
        )
    ) as exhibit:  # fmt: skip
        user.glide(exhibit, 0.5)
        assert exhibit.tours.timer.touring  # the initial pointer does not count as input
        begun = []
        for _ in range(70):
            before = exhibit.world
            exhibit.frame(0.1)
            if exhibit.world is not before:
                begun.append(before.state.tick * TICK_S)
        assert len(begun) >= 2 and np.allclose(begun, END_S, atol=0.2)
        assert exhibit.tours.timer.touring
        user.do("key", "w")
        user.until(exhibit, lambda: not exhibit.tours.timer.touring)
        before = exhibit.world
        user.glide(exhibit, AFTER_S - 0.5)
        assert exhibit.world is before  # a visitor's scene does not end
        user.glide(exhibit, 3.0)
        assert exhibit.world is not before and exhibit.tours.timer.touring
        assert caption_of(exhibit.world, 1.0).words == "Again."
        place = exhibit.world.state.submarine.position
        assert np.linalg.norm(place - (-480.0, -200.0, -250.0)) < 1.0
