"""Pages of pictures: which are written, and what they hold."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from capture.plots.pages import plot_repertoire
from subsea.base.errors import UserError
from subsea.repertoire import Repertoire, read_repertoire


def some(repertoire: Repertoire, *names: str) -> Repertoire:
    """The repertoire with these segments alone."""
    segments = {name: repertoire.segments[name] for name in names}
    return dataclasses.replace(repertoire, segments=segments)


def look(path: Path) -> NDArray[np.uint8]:
    """The grey page, pixels (height, width)."""
    with Image.open(path) as picture:
        return np.asarray(picture.convert("L"))


def test_every_segment_and_the_repertoire_get_a_page(recorded: Path, tmp_path: Path) -> None:
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
def test_motion_without_plans_is_plotted_without_simulation(
    known_repertoire: Repertoire, recorded: Path, tmp_path: Path
) -> None:
    """Without a fish in the provenance there is no steering map to measure."""
    known = plot_repertoire(some(known_repertoire, "swim_fast"), tmp_path)
    assert [path.name for path in known] == ["known_swim_fast.png", "known.png"]
    swum = plot_repertoire(some(read_repertoire(recorded), "swim_fast"), tmp_path)
    assert len(look(known[-1])) < len(look(swum[-1]))


def test_a_folder_that_cannot_be_made_is_named(recorded: Path, tmp_path: Path) -> None:
    (tmp_path / "plots").write_text("in the way")
    with pytest.raises(UserError, match=r"plots.*: cannot write"):
        plot_repertoire(some(read_repertoire(recorded), "swim_fast"), tmp_path / "plots")
