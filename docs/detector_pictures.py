"""Read sets of `subsea dataset` as arrays that a detector learns from, and score what it finds.

`docs/train_detector.py` trains on them. Nothing here needs torch. All fishes are one class. Places
are pixels from the corner of a picture.
"""

import json
from collections.abc import Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

Floats = NDArray[np.floating]

STRIDE = 4  # pixels of a cell of the detector
LEAST_PX = 8.0  # side of a box; smaller fishes are neither taught nor asked for
SIGMA = 0.079  # of OKS for each keypoint: that of shoulders in COCO
MOST = 100  # fishes found in a picture
SHOWN, COLUMNS = 12, 3  # pictures of a sheet
SURE = 0.3  # score of a fish that a sheet shows
TRUTH, FOUND, POINT = (255, 255, 255), (255, 200, 0), (255, 60, 60)


class Targets(NamedTuple):
    """Pictures (n, h, w, 3) with what a detector shall say about them, and their m fishes."""

    pixels: NDArray[np.uint8]
    heat: Floats  # (n, rows, columns): 1 in the middle cell of a fish, and a bell about it
    cells: NDArray[np.int64]  # (m, 3): picture, row and column of the middle
    boxes: Floats  # (m, 4): logarithms of width and height, and offset in the cell, all in cells
    points: Floats  # (m, k, 2): keypoints from the middle, in sizes of the box
    visible: NDArray[np.bool_]  # (m, k)


class Pictures:
    """The pictures of a set in memory, with their fishes."""

    def __init__(self, folder: Path, splits: Sequence[str]) -> None:
        """Read parts of a set in COCO format."""
        self.images: list[Any] = []
        self.fishes: list[list[Any]] = []
        pixels = []
        for split in splits:
            part = json.loads((folder / "annotations" / f"{split}.json").read_text())
            self.names: list[str] = part["categories"][0]["keypoints"]
            of_image: dict[int, list[Any]] = {one["id"]: [] for one in part["images"]}
            for fish in part["annotations"]:
                of_image[fish["image_id"]].append(fish)
            for image in part["images"]:
                path = folder / "images" / split / image["file_name"]
                pixels.append(np.asarray(Image.open(path).convert("RGB")))
                self.images.append(image)
                self.fishes.append(of_image[image["id"]])
        self.pixels = np.stack(pixels)

    def __len__(self) -> int:
        """Count the pictures."""
        return len(self.images)

    def targets(self, who: Sequence[int], mirrored: bool = False) -> Targets:
        """Return what a detector shall say about pictures, mirrored or not."""
        n, (high, wide) = len(who), self.pixels.shape[1:3]
        heat = np.zeros((n, high // STRIDE, wide // STRIDE), np.float32)
        swap = mirrored_order(self.names)
        cells, boxes, points, visible = [], [], [], []
        for k, picture in enumerate(who):
            for fish in self.fishes[picture]:
                x, y, w, h = fish["bbox"]
                named = np.reshape(np.array(fish["keypoints"], np.float32), (-1, 3))
                if mirrored:
                    x = wide - x - w
                    named[:, 0] = wide - named[:, 0]
                    named = named[swap]
                middle = np.array([x + w / 2, y + h / 2])
                column, row = np.minimum(middle // STRIDE, np.array(heat.shape[:0:-1]) - 1)
                column, row = int(column), int(row)
                asked = is_asked_for(fish)
                # Small fishes may be found, too: their bells stay below 1, and count little.
                splat(heat[k], column, row, w / STRIDE, h / STRIDE, 1.0 if asked else 0.9)
                if not asked:
                    continue
                cells.append((k, row, column))
                boxes.append((*np.log([w / STRIDE, h / STRIDE]), *(middle / STRIDE % 1.0)))
                points.append((named[:, :2] - middle) / (w, h))
                visible.append(named[:, 2] == 2)
        pixels = self.pixels[np.asarray(who)]
        return Targets(
            pixels[:, :, ::-1] if mirrored else pixels,
            heat,
            np.array(cells, np.int64).reshape(-1, 3),
            np.array(boxes, np.float32).reshape(-1, 4),
            np.array(points, np.float32).reshape(-1, len(self.names), 2),
            np.array(visible, bool).reshape(-1, len(self.names)),
        )


def is_asked_for(fish: dict[str, Any]) -> bool:
    """True for a fish that is large enough."""
    return min(fish["bbox"][2:]) >= LEAST_PX


def mirrored_order(names: Sequence[str]) -> list[int]:
    """Return the index of the keypoint that each one becomes in a mirrored picture."""
    other = {"left": "right", "right": "left"}
    found = []
    for name in names:
        side, _, part = name.partition("_")
        found.append(names.index(f"{other[side]}_{part}" if side in other else name))
    return found


def splat(heat: Floats, column: int, row: int, wide: float, high: float, peak: float) -> None:
    """Raise a map to a bell about a cell, in proportion to the fish's size in cells."""
    sigma_x, sigma_y = max(wide / 6.0, 0.7), max(high / 6.0, 0.7)
    x = np.exp(-0.5 * ((np.arange(heat.shape[1]) - column) / sigma_x) ** 2)
    y = np.exp(-0.5 * ((np.arange(heat.shape[0]) - row) / sigma_y) ** 2)
    np.maximum(heat, (peak * np.outer(y, x)).astype(heat.dtype), out=heat)


def precision(
    pictures: Pictures, found: Sequence[dict[str, Any]], kind: str
) -> tuple[float, float]:
    """Return average precision over overlaps of .5 to .95, and at .5, as COCO defines it.

    `found` are results in COCO's form. `kind` is "bbox", or "keypoints" with OKS for overlap. Small
    fishes count neither as missed nor, where they are found, as mistakes.
    """
    annotations = []
    for image, fishes in zip(pictures.images, pictures.fishes, strict=True):
        for fish in fishes:
            named = np.reshape(fish["keypoints"], (-1, 3)).astype(float)
            named[named[:, 2] != 2] = 0.0  # hidden keypoints are not asked for
            asked = is_asked_for(fish)
            annotations.append(
                {
                    "id": len(annotations) + 1, "image_id": image["id"], "category_id": 1,
                    "bbox": fish["bbox"], "area": fish["area"], "iscrowd": int(not asked),
                    "keypoints": named.ravel().tolist(),
                    "num_keypoints": int((named[:, 2] > 0).sum()) if asked else 0,
                }
            )  # fmt: skip
    if not found:
        return 0.0, 0.0
    with redirect_stdout(StringIO()):
        truth = COCO()
        truth.dataset = {
            "info": {}, "images": pictures.images, "annotations": annotations,
            "categories": [{"id": 1, "name": "fish"}],
        }  # fmt: skip
        truth.createIndex()
        scores = COCOeval(truth, truth.loadRes([dict(one) for one in found]), kind)
        scores.params.kpt_oks_sigmas = np.full(len(pictures.names), SIGMA)
        scores.params.maxDets = [MOST]
        scores.evaluate()
        scores.accumulate()
    at = scores.eval["precision"][:, :, 0, 0, -1]  # (overlaps, recalls) of all sizes
    means = [float(row[row > -1].mean()) if (row > -1).any() else np.nan for row in (at, at[0])]
    return means[0], means[1]


def sheet(pictures: Pictures, found: Sequence[dict[str, Any]]) -> Image.Image:
    """Draw the truth in white, and what was found in yellow with its keypoints in red."""
    chosen = np.linspace(0, len(pictures) - 1, min(SHOWN, len(pictures))).astype(int)
    high, wide = pictures.pixels.shape[1:3]
    page = Image.new("RGB", (COLUMNS * wide, -(-len(chosen) // COLUMNS) * high))
    for place, k in enumerate(chosen):
        picture = Image.fromarray(pictures.pixels[k])
        draw = ImageDraw.Draw(picture)
        for fish in pictures.fishes[k]:
            if is_asked_for(fish):
                draw.rectangle(_corners(fish["bbox"]), outline=TRUTH)
        for one in found:
            if one["image_id"] == pictures.images[k]["id"] and one["score"] > SURE:
                draw.rectangle(_corners(one["bbox"]), outline=FOUND)
                for x, y, _ in np.reshape(one["keypoints"], (-1, 3)):
                    draw.point((x, y), POINT)
        page.paste(picture, (place % COLUMNS * wide, place // COLUMNS * high))
    return page


def _corners(box: Sequence[float]) -> tuple[float, float, float, float]:
    x, y, w, h = box
    return x, y, x + w - 1, y + h - 1
