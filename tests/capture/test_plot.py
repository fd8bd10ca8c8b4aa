from pathlib import Path

import pytest

from capture.plot import plot_repertoire
from subsea.errors import UserError
from subsea.repertoire import Repertoire


def test_every_segment_gets_a_film_strip(
    repertoires: dict[str, Repertoire], tmp_path: Path
) -> None:
    written = plot_repertoire(repertoires["fusilier"], tmp_path / "plots")
    assert {path.stem for path in written} >= {"fusilier_strip_swim_fast", "fusilier_paths"}
    assert len(written) == 9
    for path in written:
        assert path.read_bytes().startswith(b"\x89PNG")


def test_a_folder_that_cannot_be_made_is_named(
    repertoires: dict[str, Repertoire], tmp_path: Path
) -> None:
    (tmp_path / "plots").write_text("in the way")
    with pytest.raises(UserError, match="plots: cannot write"):
        plot_repertoire(repertoires["fusilier"], tmp_path / "plots")
