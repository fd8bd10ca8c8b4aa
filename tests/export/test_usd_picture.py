"""The picture of a USD scene through its own camera against the film of the same moment."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd

from subsea.dive.directed_camera import tour_steering
from subsea.dive.start import picture_maker, ready_world
from subsea.export.options import SceneOptions
from subsea.export.recording import SceneFilmOptions
from subsea.export.scene import Scene
from subsea.export.usd_scene import WRITER
from subsea.frame.packet import pack
from subsea.media.film import reach
from subsea.rendering.gl.context import headless_context
from subsea.rendering.gl.id_buffer import FISH, ROCK, SEABED
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.reef import rocks
from subsea.view.display_rigs import cockpit, display_rig
from subsea.view.rig import views
from subsea.world.world import TICK_S
from tests.support.usd_raster import label_map

SIZE, FRAME = (640, 360), 45
KINDS = {"fishes": FISH, "sand": SEABED, "stone": ROCK}


@pytest.fixture(scope="module")
def context() -> Iterator[Any]:
    context = headless_context()
    yield context
    context.release()


def filmed(context: Any, options: SceneFilmOptions) -> Any:
    """Kinds and numbers of what each pixel of the film's frame shows."""
    world = ready_world(options.loaded)
    rig = display_rig("mono", SIZE)
    steer = tour_steering(world, "auto")
    alpha = reach(world, FRAME * TICK_S, steer, lambda: None)
    seen = views(rig, cockpit(world.state.submarine, alpha))
    with context, picture_maker(context, world, rig, PRESETS["low"]) as renderer:
        packet = pack(world, seen, alpha)
        renderer.draw(packet)
        return renderer.id_maps(packet)


@pytest.mark.nightly
def test_fishes_sand_and_stone_cover_the_pixels_of_the_film(
    context: Any, dive: Scene, short_dive: SceneFilmOptions, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    finer = short_dive.detail + 1  # levels of stone before the one that is exported
    levels_px = np.where(np.arange(len(rocks.LEVELS_PX)) < finer, np.inf, 0.0)
    monkeypatch.setattr(rocks, "LEVELS_PX", levels_px)
    film = filmed(context, short_dive)
    WRITER.write(dive, tmp_path / "bare.usdc", SceneOptions())
    stage = Usd.Stage.Open(str(tmp_path / "bare.usdc"))
    numbers = {fish.name: fish.number for fish in dive.fishes}

    def label(path: str) -> float:
        _, _, group, name, *_ = path.split("/")
        return KINDS[group] * 100 + numbers.get(name, 0)

    with context:
        found = label_map(context, stage, "/bare_sea/camera", FRAME, SIZE, label)
    expected = film.kind * 100.0 + np.where(film.kind == FISH, film.number, 0)
    shares = {}
    for name, kind in KINDS.items():
        one, other = (np.abs(values // 100 - kind) < 0.5 for values in (found, expected))
        assert other.sum() > 300, name  # it is in the picture
        shares[name] = (one & other).sum() / (one | other).sum()
    assert shares["fishes"] > 0.9 and shares["sand"] > 0.94 and shares["stone"] > 0.98, shares
    both = (found // 100 == FISH) & (expected // 100 == FISH)
    assert (found[both] == expected[both]).mean() > 0.99  # each is that fish
