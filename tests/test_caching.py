"""Compiled code is not older than the code that it calls."""

from pathlib import Path

from subsea.behavior.steering import heed
from subsea.caching import ROOT, stamp


def _write(folder: Path, **files: str) -> None:
    for name, text in files.items():
        file = folder / "subsea" / f"{name}.py"
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")


def _project(tmp_path: Path, name: str, **changed: str) -> str:
    """The stamp of a.py, which imports b.py, which imports c.py; nobody imports d.py."""
    folder = tmp_path / name
    folder.mkdir()
    files = {
        "a": "from subsea.b import (\n    x,\n    y,\n)\n",
        "b": "import math\nfrom subsea import c\n",
        "c": "from subsea.a import z\nK = 1\n",
        "d": "K = 1\n",
    }
    _write(folder, **(files | changed))
    return stamp(folder / "subsea" / "a.py", folder)


def test_a_change_of_anything_imported_changes_the_stamp(tmp_path):
    before = _project(tmp_path, "before")
    assert _project(tmp_path, "same") == before
    assert _project(tmp_path, "far", c="from subsea.a import z\nK = 2\n") != before
    assert _project(tmp_path, "unrelated", d="K = 2\n") == before


def test_kernels_are_kept_by_that_stamp():
    file = ROOT / "subsea" / "behavior" / "steering.py"
    assert heed._cache._impl.locator.get_source_stamp() == stamp(file)
