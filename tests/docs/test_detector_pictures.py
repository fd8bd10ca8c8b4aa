"""docs/detector_pictures.py: targets of a detector, and the precision of what it finds."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from subsea.lab.dataset.keypoints import FLIPPED, NAMES
from subsea.lab.dataset.make import make_dataset
from subsea.lab.dataset.scenes import DatasetPlan
from tests.support.scenes import BARE

DOCS = Path(__file__).parents[2] / "docs"
PLAN = DatasetPlan(
    str(BARE), seed=2, size=(160, 96), per_scene=3, settle_s=(0.5, 1.0), quality="low", val=0.0
)


@pytest.fixture(scope="module")
def module():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(DOCS)
        yield import_module("detector_pictures")


@pytest.fixture(scope="module")
def pictures(module, tmp_path_factory):
    out = tmp_path_factory.mktemp("set")
    make_dataset(PLAN, 6, out, shard=3)
    return module.Pictures(out, ("train", "val"))


def asked_for(module, pictures):
    return [
        (image, fish)
        for image, fishes in zip(pictures.images, pictures.fishes, strict=True)
        for fish in fishes
        if module.is_asked_for(fish)
    ]


def results(module, pictures, shift=0.0):
    """The truth as results, shifted by a share of the size of each box."""
    found = []
    for image, fish in asked_for(module, pictures):
        x, y, w, h = fish["bbox"]
        points = np.reshape(fish["keypoints"], (-1, 3)) + [shift * w, 0.0, 0.0]
        found.append(
            {
                "image_id": image["id"], "category_id": 1, "bbox": [x + shift * w, y, w, h],
                "keypoints": points.ravel().tolist(), "score": 0.9,
            }
        )  # fmt: skip
    return found


def decoded(module, targets):
    """Boxes (m, 4) and keypoints (m, k, 2) in pixels, as targets describe them."""
    middle = module.STRIDE * (targets.cells[:, :0:-1] + targets.boxes[:, 2:])
    size = module.STRIDE * np.exp(targets.boxes[:, :2])
    boxes = np.concatenate([middle - size / 2, size], axis=1)
    return boxes, middle[:, None] + targets.points * size[:, None]


def test_targets_describe_the_fishes(module, pictures):
    targets = pictures.targets(range(len(pictures)))
    fishes = [fish for _, fish in asked_for(module, pictures)]
    assert len(fishes) >= 5
    boxes, points = decoded(module, targets)
    np.testing.assert_allclose(boxes, [fish["bbox"] for fish in fishes], atol=1e-3)
    named = np.array([np.reshape(fish["keypoints"], (-1, 3)) for fish in fishes])
    np.testing.assert_array_equal(targets.visible, named[..., 2] == 2)
    assert targets.visible.any()
    np.testing.assert_allclose(points[targets.visible], named[targets.visible][:, :2], atol=1e-3)
    k, row, column = targets.cells.T
    assert (targets.heat[k, row, column] == 1.0).all()
    assert (targets.heat == 1.0).sum() == len(np.unique(targets.cells, axis=0))


def test_a_mirrored_picture_has_mirrored_targets(module, pictures):
    plain, mirrored = (pictures.targets([0, 1, 2], flag) for flag in (False, True))
    np.testing.assert_array_equal(plain.pixels[:, :, ::-1], mirrored.pixels)
    wide = plain.pixels.shape[2]
    boxes, points = decoded(module, plain)
    others, other_points = decoded(module, mirrored)
    np.testing.assert_allclose(wide - boxes[:, 0] - boxes[:, 2], others[:, 0], atol=1e-3)
    swap = list(FLIPPED)
    np.testing.assert_array_equal(plain.visible[:, swap], mirrored.visible)
    seen = mirrored.visible
    points[..., 0] = wide - points[..., 0]
    np.testing.assert_allclose(points[:, swap][seen], other_points[seen], atol=1e-3)
    assert module.mirrored_order(NAMES) == swap


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")  # of numpy 2
def test_precision_is_1_for_the_truth_and_falls_with_mistakes(module, pictures):
    for kind in ("bbox", "keypoints"):
        assert module.precision(pictures, results(module, pictures), kind) == (1.0, 1.0)
        assert module.precision(pictures, [], kind) == (0.0, 0.0)
    mean, half = module.precision(pictures, results(module, pictures, 0.2), "bbox")  # overlap .67
    assert half == 1.0
    assert mean == pytest.approx(0.4)  # .5, .55, .6 and .65
    fewer = results(module, pictures)[::2]
    assert module.precision(pictures, fewer, "bbox")[0] < 0.7
    assert module.precision(pictures, results(module, pictures, 3.0), "keypoints")[1] < 0.1


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")
def test_small_fishes_that_are_found_are_no_mistakes(module, pictures, monkeypatch):
    found = results(module, pictures)
    sizes = sorted(min(fish["bbox"][2:]) for _, fish in asked_for(module, pictures))
    monkeypatch.setattr(module, "LEAST_PX", float(np.mean(sizes[-3:-1])))
    assert 0 < len(asked_for(module, pictures)) < len(found)
    assert module.precision(pictures, found, "bbox") == (1.0, 1.0)


def test_a_sheet_shows_truth_and_results(module, pictures):
    page = np.asarray(module.sheet(pictures, results(module, pictures, 0.3)))
    for colour in (module.TRUTH, module.FOUND, module.POINT):
        assert (page == colour).all(axis=-1).any()
