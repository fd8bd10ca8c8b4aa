"""Pages of pictures: which are written, and what they hold."""

import dataclasses

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

from capture.plots import pages, panels
from capture.plots.pages import plot_repertoire
from subsea.base.errors import UserError
from subsea.repertoire import read_repertoire


def some(repertoire, *names):
    """The repertoire with these segments alone."""
    segments = {name: repertoire.segments[name] for name in names}
    return dataclasses.replace(repertoire, segments=segments)


def look(path):
    """The grey page, pixels (height, width)."""
    with Image.open(path) as picture:
        return np.asarray(picture.convert("L"))


@pytest.mark.nightly
def test_every_segment_and_the_repertoire_get_a_page(recorded, tmp_path):
    chosen = some(read_repertoire(recorded), "turn_left_sharp", "swim_fast")
    written = plot_repertoire(chosen, tmp_path / "plots")
    names = ["fusilier_swim_fast.png", "fusilier_turn_left_sharp.png", "fusilier.png"]
    assert [path.name for path in written] == names
    assert sorted(path.name for path in (tmp_path / "plots").iterdir()) == sorted(names)
    for path in written:
        page = look(path)
        assert page.shape[1] == 1200
        assert 0.03 < (page < 250).mean() < 0.5  # neither empty nor blotted


@pytest.mark.nightly
def test_motion_without_plans_is_plotted_without_simulation(known_repertoire, recorded, tmp_path):
    """Without a fish in the provenance there is no steering map to measure."""
    known = plot_repertoire(some(known_repertoire, "swim_fast"), tmp_path)
    assert [path.name for path in known] == ["known_swim_fast.png", "known.png"]
    swum = plot_repertoire(some(read_repertoire(recorded), "swim_fast"), tmp_path)
    assert len(look(known[-1])) < len(look(swum[-1]))


def test_a_note_is_in_place_of_what_cannot_be_simulated(recorded, monkeypatch):
    def fails(*trial):
        raise UserError("the body lost its shape in beat 3")

    monkeypatch.setattr(pages, "speed_map", fails)
    monkeypatch.setattr(pages, "run_trial", fails)
    chosen, page = some(read_repertoire(recorded), "swim_fast"), Figure()
    motion = pages._motion(chosen)
    pages._repertoire_page(page, chosen, motion)
    notes = [text.get_text() for text in page.findobj(Text)]
    assert sum("the body lost its shape in beat 3" in note for note in notes) == 2
    assert "Steering map" in notes  # is drawn all the same
    assert pages._first_frame(chosen, motion, "swim_fast") is None
    monkeypatch.undo()
    monkeypatch.setattr(pages, "turned", fails)
    angles = pages._turned(motion)
    assert np.isnan(angles).all()
    panels.turned(Figure().subplots(), pages.ANGLES, angles)  # no warning


def test_a_folder_that_cannot_be_made_is_named(recorded, tmp_path):
    (tmp_path / "plots").write_text("in the way")
    with pytest.raises(UserError, match=r"plots.*: cannot write"):
        plot_repertoire(some(read_repertoire(recorded), "swim_fast"), tmp_path / "plots")
