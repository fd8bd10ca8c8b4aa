"""Pictures of a world without a window, from any thread, of any world."""

import gc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import subsea
from subsea import library as pictures
from tests.support.scenes import BARE


@pytest.fixture(scope="module")
def world():
    world = subsea.load(str(BARE), seed=5, fish=8)
    world.step(3)
    return world


def test_a_picture_depends_on_the_world_and_the_camera_alone(world):
    before = world.checksum()
    first = subsea.render(world, size=(96, 64))
    other = subsea.render(world, subsea.behind(world, 2), (96, 64))
    assert first.shape == other.shape == (64, 96, 3)
    assert first.dtype == np.uint8
    assert np.abs(first.astype(int) - other).mean() > 2.0
    subsea.render(world, size=(40, 40), quality="low")
    np.testing.assert_array_equal(subsea.render(world, size=(96, 64)), first)
    assert world.checksum() == before


def test_a_camera_looks_at_its_target(world):
    eye = np.array([100.0, 50.0, -150.0])
    views = [subsea.camera(eye, eye + (0.0, 1.0, way)) for way in (-100.0, 100.0)]
    assert views[0].forward @ views[0].up == pytest.approx(0.0)
    sand, surface = (subsea.render(world, one, (48, 48)).mean(axis=(0, 1)) for one in views)
    assert sand[0] / sand[2] > surface[0] / surface[2]  # redder below


def test_a_fish_sees_others_and_not_itself(world):
    seen = [subsea.retina(world, k) for k in range(8)]
    fishes = [set(np.unique(one.identity[one.identity >= 10000]) - 10000) for one in seen]
    assert any(fishes)
    assert not any(k in found for k, found in enumerate(fishes))
    assert seen[0].picture.shape == (2, 64, 64, 3)
    assert seen[0].depth.shape == seen[0].identity.shape == (2, 64, 64)
    assert all(np.isfinite(one.depth[one.identity >= 10000]).all() for one in seen)
    for one in seen:
        for side, row, column in np.argwhere(one.identity >= 10000):
            fish = one.identity[side, row, column] - 10000
            z = one.depth[side, row, column]
            eye = np.array([(column - 31.5) * z / 32, (row - 31.5) * z / 32, z, 1.0])
            place = (np.linalg.inv(one.matrices[side]) @ eye)[:3]
            far = np.linalg.norm(place - world.fishes.position[fish])
            assert far < 0.7 * world.fishes.length[fish]  # a pixel of a fish is where the fish is


def test_worlds_are_drawn_from_any_thread_and_freed(world):
    expected = subsea.render(world, size=(48, 32))
    with ThreadPoolExecutor(2) as pool:
        drawn = list(pool.map(lambda _: subsea.render(world, size=(48, 32)), range(4)))
    assert all((one == expected).all() for one in drawn)
    other = subsea.load(str(BARE), seed=6, fish=3)
    subsea.render(other, size=(16, 16))
    held = len(pictures._renderers)
    del other
    gc.collect()
    assert len(pictures._renderers) == held - 1
    np.testing.assert_array_equal(subsea.render(world, size=(48, 32)), expected)


@pytest.mark.parametrize("size", [(0, 2), (2, 9000), (2,), (2.5, 2), "ab", None])
def test_a_wrong_size_is_named(world, size):
    with pytest.raises(ValueError, match="size: expected width and height from 1 to 8192"):
        subsea.render(world, size=size)
    with pytest.raises(ValueError, match="size: expected"):
        subsea.retina(world, 0, size=size)


def test_wrong_views_are_named(world):
    with pytest.raises(subsea.UserError, match="unknown quality 'hihg'"):
        subsea.render(world, quality="hihg")
    with pytest.raises(ValueError, match="fish 8: expected one from 0 to 7"):
        subsea.retina(world, 8)
    with pytest.raises(ValueError, match=r"camera: eye .*, expected three finite numbers"):
        subsea.camera((0, 0, np.nan), (1, 0, 0))
    with pytest.raises(ValueError, match="the target lies at the eye or along `up`"):
        subsea.camera((0, 0, 0), (0, 0, 9))
