"""A picture is painted once, and nothing that happens to its file can do harm."""

import numpy as np
import pytest

from subsea.render.kept import cache_folder, kept

SHAPE = (4, 6, 4)


@pytest.fixture
def painter(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    calls = []

    def paint():
        calls.append(None)
        return np.full(SHAPE, len(calls), np.uint8)

    return paint, calls


def test_it_is_painted_once(painter):
    paint, calls = painter
    assert (kept(paint, SHAPE, b"fish") == 1).all()
    assert (kept(paint, SHAPE, b"fish") == 1).all()
    assert len(calls) == 1


def test_another_origin_is_another_picture(painter):
    paint, calls = painter
    for origin in ((b"fish",), (b"fish", b"program"), (b"fishprogram",)):
        kept(paint, SHAPE, *origin)
    assert len(calls) == 3


@pytest.mark.parametrize("damage", ["cut", "foreign", "pickle", "shape"])
def test_a_damaged_file_is_painted_again(painter, damage):
    paint, _ = painter
    kept(paint, SHAPE, b"fish")
    (path,) = cache_folder().glob("*.npy")
    if damage == "cut":
        path.write_bytes(path.read_bytes()[:-10])
    elif damage == "foreign":
        path.write_text("not an array")
    elif damage == "pickle":
        np.save(path, np.array([{}], object), allow_pickle=True)
    else:
        np.save(path, np.zeros((2, 2), np.uint8))
    assert (kept(paint, SHAPE, b"fish") == 2).all()
    assert (kept(paint, SHAPE, b"fish") == 2).all()


def test_a_cache_that_cannot_be_written_does_no_harm(painter, monkeypatch):
    paint, _ = painter
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc/nowhere")
    assert (kept(paint, SHAPE, b"fish") == 1).all()
