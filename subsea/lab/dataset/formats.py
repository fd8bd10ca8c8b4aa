"""Write the pictures of shards in the formats that detectors, pose heads and trackers read."""

import csv
import filecmp
import io
import json
import os
import shutil
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from subsea.base.files import replacing
from subsea.lab.dataset.keypoints import FLIPPED, NAMES, SKELETON
from subsea.lab.dataset.labelling import HIDDEN, VISIBLE
from subsea.lab.dataset.scenes import DatasetPlan
from subsea.lab.dataset.shards import image_name, read_shard

SPLITS = ("train", "val")
LEAST_PX = 12  # visible pixels of a fish that is annotated
SCORER = "subsea"
TICKS_S = 1 / 0.033

Picture = dict[str, Any]  # the content of its ``.json``
Write = Callable[[Path, DatasetPlan, tuple[str, ...], Iterable[Path]], None]


def write_images(out: Path, shards: Iterable[Path]) -> None:
    """Write the pictures of shards to ``images/SPLIT``, except for those that are there."""
    for shard in shards:
        for about, files in read_shard(shard):
            path = image_path(out, about)
            if not (path.is_file() and path.read_bytes() == files["jpg"]):
                with replacing(path) as temporary:
                    temporary.write_bytes(files["jpg"])


def image_path(out: Path, about: Picture) -> Path:
    """Return the path of a picture."""
    return out / "images" / about["split"] / f"{image_name(about['image'])}.jpg"


def _pictures(shards: Iterable[Path]) -> Iterator[Picture]:
    for shard in shards:
        for about, _ in read_shard(shard):
            yield about


def annotated(about: Picture) -> list[dict[str, Any]]:
    """Choose the fishes of a picture that are large enough and not lost in the water."""
    return [
        fish
        for fish in about["fishes"]
        if fish["pixels"] >= LEAST_PX and fish["distance_cm"] <= about["visibility_cm"]
    ]


def write_coco(
    out: Path, plan: DatasetPlan, species: tuple[str, ...], shards: Iterable[Path]
) -> None:
    """Write ``annotations/SPLIT.json`` with boxes, masks and keypoints."""
    content: dict[str, dict[str, Any]] = {
        split: {
            "info": {"description": f"{plan.scenario}, made by subsea", "version": "1"},
            "licenses": [],
            "categories": [
                {
                    "id": k + 1, "name": name, "supercategory": "fish", "keypoints": list(NAMES),
                    "skeleton": [[NAMES.index(a) + 1, NAMES.index(b) + 1] for a, b in SKELETON],
                }
                for k, name in enumerate(species)
            ],
            "images": [],
            "annotations": [],
        }
        for split in SPLITS
    }  # fmt: skip
    for about in _pictures(shards):
        part = content[about["split"]]
        part["images"].append(
            {
                "id": about["image"],
                "file_name": f"{image_name(about['image'])}.jpg",
                "width": about["width"],
                "height": about["height"],
            }
        )
        for fish in annotated(about):
            keypoints = [_coco_keypoint(*one) for one in fish["keypoints"]]
            part["annotations"].append(
                {
                    "id": len(part["annotations"]) + 1,
                    "image_id": about["image"],
                    "category_id": species.index(fish["species"]) + 1,
                    "iscrowd": 0,
                    "bbox": fish["box"],
                    "area": fish["pixels"],
                    "segmentation": {
                        "size": [about["height"], about["width"]], "counts": fish["rle"],
                    },
                    "keypoints": [value for one in keypoints for value in one],
                    "num_keypoints": sum(one[2] > 0 for one in keypoints),
                    "amodal_bbox": fish["whole"],
                    "visible_share": fish["share"],
                    "fish": fish["number"],
                    "distance_cm": fish["distance_cm"],
                }
            )  # fmt: skip
    for split, part in content.items():
        _write(out / "annotations" / f"{split}.json", json.dumps(part))


def _coco_keypoint(x: float, y: float, state: int, z: float, by: int) -> list[float]:
    """Return x, y from the corner of the picture, and 0 unknown, 1 hidden, 2 visible."""
    return [round(x + 0.5, 3), round(y + 0.5, 3), state] if state >= HIDDEN else [0, 0, 0]


def write_yolo(
    out: Path, plan: DatasetPlan, species: tuple[str, ...], shards: Iterable[Path]
) -> None:
    """Write ``labels`` for detection, ``pose/labels`` for keypoints, and a YAML file for each."""
    splits = set()
    for about in _pictures(shards):
        splits.add(about["split"])
        wide, high = about["width"], about["height"]
        boxes, poses = [], []
        for fish in annotated(about):
            x, y, w, h = fish["box"]
            box = (x + w / 2) / wide, (y + h / 2) / high, w / wide, h / high
            text = " ".join([str(species.index(fish["species"])), *(f"{one:.6f}" for one in box)])
            boxes.append(text)
            points = [_coco_keypoint(*one) for one in fish["keypoints"]]
            poses.append(
                " ".join([text, *(f"{a / wide:.6f} {b / high:.6f} {v:g}" for a, b, v in points)])
            )
        name, split = image_name(about["image"]), about["split"]
        _write(out / "labels" / split / f"{name}.txt", _lines(boxes))
        _write(out / "pose" / "labels" / split / f"{name}.txt", _lines(poses))
        _link(image_path(out, about), out / "pose" / "images" / split / f"{name}.jpg")
    names = "".join(f"  {k}: {json.dumps(name)}\n" for k, name in enumerate(species))
    # The programs ask for both parts, also of a set that has one.
    parts = "".join(f"{one}: images/{one if one in splits else min(splits)}\n" for one in SPLITS)
    common = f"{parts}names:\n{names}"
    _write(out / "detect.yaml", common)
    pose = f"kpt_shape: [{len(NAMES)}, 3]\nflip_idx: {list(FLIPPED)}\n"
    _write(out / "pose" / "pose.yaml", common + pose)


def write_mot(
    out: Path, plan: DatasetPlan, species: tuple[str, ...], shards: Iterable[Path]
) -> None:
    """Write each scene as a sequence of MOTChallenge: ``mot/SPLIT/SCENE/img1``, ``gt/gt.txt``."""
    rows: dict[Path, list[str]] = {}
    for about in _pictures(shards):
        folder = out / "mot" / about["split"] / f"scene_{about['scene']:05}"
        frame = about["image"] % plan.per_scene + 1
        _link(image_path(out, about), folder / "img1" / f"{frame:06}.jpg")
        lines = rows.setdefault(folder, [])
        for fish in annotated(about):
            x, y, w, h = fish["box"]
            # Frame, track, box from 1, considered, class, visibility.
            lines.append(
                f"{frame},{fish['number'] + 1},{x + 1:g},{y + 1:g},{w:g},{h:g},1,"
                f"{species.index(fish['species']) + 1},{fish['share']:.4f}"
            )
    for folder, lines in rows.items():
        _write(folder / "gt" / "gt.txt", _lines(lines))
        length = len(list((folder / "img1").glob("*.jpg")))
        _write(
            folder / "seqinfo.ini",
            f"[Sequence]\nname={folder.name}\nimDir=img1\nframeRate={TICKS_S / plan.every:g}\n"
            f"seqLength={length}\nimWidth={plan.size[0]}\nimHeight={plan.size[1]}\nimExt=.jpg\n",
        )


def write_deeplabcut(
    out: Path, plan: DatasetPlan, species: tuple[str, ...], shards: Iterable[Path]
) -> None:
    """Write each scene as a folder of a DeepLabCut project with several animals.

    ``deeplabcut/labeled-data/SCENE/CollectedData_subsea.csv`` has the visible keypoints.
    `deeplabcut.convertcsv2h5` makes the HDF5 file of it.
    """
    scenes: dict[int, list[Picture]] = {}
    for about in _pictures(shards):
        scenes.setdefault(about["scene"], []).append(about)
        folder = out / "deeplabcut" / "labeled-data" / f"scene_{about['scene']:05}"
        _link(image_path(out, about), folder / f"{image_name(about['image'])}.jpg")
    most = 1
    for scene, pictures in scenes.items():
        numbers = sorted({fish["number"] for about in pictures for fish in annotated(about)})
        most = max(most, len(numbers))
        columns = [(f"fish{n}", part, axis) for n in numbers for part in NAMES for axis in "xy"]
        heads = [
            ["scorer", "", ""] + [SCORER] * len(columns),
            *(
                [label, "", ""] + [column[k] for column in columns]
                for k, label in enumerate(("individuals", "bodyparts", "coords"))
            ),
        ]
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerows(heads)
        name = f"scene_{scene:05}"
        for about in pictures:
            seen = {fish["number"]: fish["keypoints"] for fish in annotated(about)}
            values: list[Any] = []
            for number in numbers:
                for x, y, state, *_ in seen.get(number, [[0, 0, 0]] * len(NAMES)):
                    values += [x, y] if state == VISIBLE else ["", ""]
            writer.writerow(["labeled-data", name, f"{image_name(about['image'])}.jpg", *values])
        path = out / "deeplabcut" / "labeled-data" / name / f"CollectedData_{SCORER}.csv"
        _write(path, text.getvalue())
    individuals = sorted(
        {f"fish{f['number']}" for some in scenes.values() for a in some for f in annotated(a)},
        key=lambda name: int(name[4:]),
    )
    _write(
        out / "deeplabcut" / "config.yaml",
        f"Task: {json.dumps(plan.scenario)}\nscorer: {SCORER}\nmultianimalproject: true\n"
        f"identity: true\nindividuals:\n{_items(individuals)}multianimalbodyparts:\n"
        f"{_items(NAMES)}uniquebodyparts: []\nbodyparts: MULTI!\nskeleton:\n"
        + "".join(f"- - {a}\n  - {b}\n" for a, b in SKELETON)
        + "video_sets: {}\n",
    )


def write_webdataset(
    out: Path, plan: DatasetPlan, species: tuple[str, ...], shards: Iterable[Path]
) -> None:
    """Write nothing: the shards are in this format."""


FOLDERS = "images", "annotations", "labels", "pose", "mot", "deeplabcut"  # that formats write


def remove_formats(out: Path) -> None:
    """Remove what formats wrote to the folder of a set, which another set replaces."""
    for name in FOLDERS:
        shutil.rmtree(out / name, ignore_errors=True)


FORMATS: dict[str, Write] = {
    "coco": write_coco,
    "yolo": write_yolo,
    "mot": write_mot,
    "deeplabcut": write_deeplabcut,
    "webdataset": write_webdataset,
}


def _items(names: Iterable[str]) -> str:
    return "".join(f"- {name}\n" for name in names)


def _lines(lines: list[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


def _write(path: Path, text: str) -> None:
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _link(source: Path, path: Path) -> None:
    """Put a file at another place, too: by a link if the disk has these, else as a copy."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.is_file() and filecmp.cmp(source, path, shallow=False):
        return
    with replacing(path) as temporary:
        temporary.unlink()
        try:
            os.link(source, temporary)
        except OSError:
            shutil.copyfile(source, temporary)
