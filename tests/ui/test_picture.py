"""Text on the panel of a theatre's vessel."""

from types import SimpleNamespace

import pytest

from subsea.stage.setup import set_up_theatre
from subsea.ui.picture import ScenePicture
from subsea.view.theatre_vessel import PANEL_SIZE


def panel_of(tmp_path, table, points=(900, 900), **fields):
    """The text panel of a picture of the shipped dome with a vessel."""
    path = tmp_path / "dome.toml"
    text = (
        'window = [{ name = "w", size = [200, 200] }]\n'
        '[[channel]]\nname = "dome"\nwindow = "w"\ndome = {}\n'
    )
    path.write_text(text + table)
    windows = SimpleNamespace(front=SimpleNamespace(points=points))
    picture = SimpleNamespace(
        rig=set_up_theatre(str(path)).rig, head=None, ride=None, _window_set=windows,
        _use_panel=lambda number: None,
    )  # fmt: skip
    vars(picture).update(fields)
    return ScenePicture.text_panel.fget(picture)


@pytest.mark.parametrize("points", [(900, 900), (1920, 1080), (4000, 1000)])
def test_the_panel_takes_text_of_its_own_shape(tmp_path, points):
    viewport = panel_of(tmp_path, "[vessel]\n", points)
    width, height = (share * size for share, size in zip(viewport.screen, points, strict=True))
    assert width / height == pytest.approx(PANEL_SIZE[0] / PANEL_SIZE[1])


def test_text_stays_in_the_window_without_a_panel(tmp_path):
    assert panel_of(tmp_path, "") is None
    assert panel_of(tmp_path, "[vessel]\ninstruments = false\n") is None
    assert panel_of(tmp_path, "[vessel]\n", ride=object()) is None  # a fish has no vessel
    assert panel_of(tmp_path, "[vessel]\n", head=object()) is None
