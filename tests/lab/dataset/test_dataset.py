"""Sets of labelled pictures: equal bytes, resuming, formats that other programs load, bad input."""

import contextlib
import csv
import io
import json
import os
import signal
import subprocess
import sys
import tarfile
import time
from dataclasses import replace

import numpy as np
import pandas
import pytest
from distributed import LocalCluster
from PIL import Image
from pycocotools import mask as coco_masks
from pycocotools.coco import COCO

from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.jobs.dask_cluster import dask_pool
from subsea.lab.dataset import shards as module
from subsea.lab.dataset.formats import annotated
from subsea.lab.dataset.keypoints import NAMES
from subsea.lab.dataset.make import make_dataset
from subsea.lab.dataset.ranges import DrawnRange, drawn, read_ranges
from subsea.lab.dataset.scenes import DatasetPlan, shots
from subsea.lab.dataset.shards import make_shards, read_shard
from tests.support.scenes import BARE

VARY = (
    "water.hour=8:16", "camera.field_deg=50:90", "sensor.noise=0:6", "jpeg.quality=60:95",
    "camera.lamps=true,false",
)  # fmt: skip
PLAN = DatasetPlan(
    str(BARE),
    seed=3,
    size=(96, 72),
    ranges=read_ranges(VARY),
    per_scene=3,
    settle_s=(0.5, 1.5),
    maps=("identity", "depth", "normal", "flow"),
    quality="low",
    val=0.4,
)
IMAGES = 8


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A set of eight pictures in shards of three, in all formats without sequences."""
    out = tmp_path_factory.mktemp("set")
    make_dataset(PLAN, IMAGES, out, formats=("coco", "yolo", "deeplabcut", "webdataset"), shard=3)
    return out


def pictures(out):
    return [one for path in sorted((out / "shards").glob("*.tar")) for one in read_shard(path)]


def test_a_picture_has_the_same_bytes_alone_and_in_shards_of_any_size(made):
    for number in (1, 5):
        [alone] = shots(PLAN, PLAN.scenario, range(number, number + 1))
        about, files = pictures(made)[number]
        assert alone.about == about
        assert {key: data for key, data in alone.files.items() if key != "json"} == files


def test_pictures_differ_and_so_do_their_settings(made):
    found = pictures(made)
    assert [about["image"] for about, _ in found] == list(range(IMAGES))
    assert len({files["jpg"] for _, files in found}) == IMAGES
    fields = [about["settings"]["camera.field_deg"] for about, _ in found]
    assert len(set(fields)) == IMAGES
    assert min(fields) > 50 and max(fields) < 90
    hours = {about["scene"]: about["scene_values"]["water.hour"] for about, _ in found}
    assert len(set(hours.values())) == 3
    assert {about["split"] for about, _ in found} == {"train", "val"}


def test_maps_are_those_of_the_labels(made):
    for about, files in pictures(made):
        identity, depth, normal, forward = (
            np.array(Image.open(io.BytesIO(files[f"{name}.png"])))
            for name in ("identity", "depth", "normal", "flow_forward")
        )
        assert identity.shape == depth.shape == (72, 96)
        assert normal.shape == forward.shape == (72, 96, 3)
        for fish in about["fishes"]:
            assert (identity == 10000 + fish["number"]).sum() == fish["pixels"]
        assert (depth[identity == 0] == 0).all()
        assert (depth[identity == 2] > 0).all()


def test_flow_is_written_as_kitti_has_it():
    from subsea.lab.dataset.sensor import flow_map, png

    flow = np.array([[[1.0, -2.5], [np.nan, 0.0]]])
    import cv2

    read = cv2.imdecode(np.frombuffer(png(flow_map(flow)), np.uint8), cv2.IMREAD_UNCHANGED)
    # OpenCV has blue first.
    assert read[0, 0].tolist() == [1, 2**15 - 160, 2**15 + 64]
    assert read[0, 1].tolist() == [0, 0, 0]


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")  # of numpy 2
def test_coco_loads_with_its_masks_and_keypoints(made):
    for split in ("train", "val"):
        with contextlib.redirect_stdout(io.StringIO()):
            coco = COCO(made / "annotations" / f"{split}.json")
        shots_of = {about["image"]: files for about, files in pictures(made)}
        assert coco.getImgIds()
        for key in coco.getAnnIds():
            [one] = coco.loadAnns([key])
            mask = coco.annToMask(one).astype(bool)
            identity = np.array(Image.open(io.BytesIO(shots_of[one["image_id"]]["identity.png"])))
            np.testing.assert_array_equal(mask, identity == 10000 + one["fish"])
            assert mask.sum() == one["area"]
            assert one["bbox"] == coco_masks.toBbox(one["segmentation"]).tolist()
            assert len(one["keypoints"]) == 3 * len(NAMES)
            points = np.reshape(one["keypoints"], (-1, 3))
            assert (points[:, 2] > 0).sum() == one["num_keypoints"]
            for x, y, v in points:
                if v == 2:
                    around = mask[max(int(y) - 1, 0) : int(y) + 2, max(int(x) - 1, 0) : int(x) + 2]
                    assert around.any()
        names = {one["name"] for one in coco.loadCats(coco.getCatIds())}
        assert {"Yellowback fusilier", "Ocellaris clownfish"} <= names
        for image in coco.loadImgs(coco.getImgIds()):
            assert (made / "images" / split / image["file_name"]).is_file()


@pytest.mark.parametrize("seed", range(20))
def test_run_lengths_are_those_of_pycocotools(seed):
    from subsea.lab.dataset.sensor import masks_of, packed_runs, run_lengths

    random = np.random.default_rng(seed)
    mask = random.random((random.integers(1, 40), random.integers(1, 300))) < random.random()
    mask[random.random(mask.shape) < 0.5] = seed % 2
    theirs = coco_masks.encode(np.asfortranarray(mask.astype(np.uint8)))["counts"].decode()
    places = np.flatnonzero(mask.T.ravel())
    assert packed_runs(run_lengths(places, mask.size)) == theirs
    if mask.any():
        assert masks_of(np.where(mask, 10007, 3), 10000) == {10007: theirs}


def test_yolo_has_a_line_for_each_fish_of_coco(made):
    for about, _ in pictures(made):
        name = f"{about['image']:07}.txt"
        boxes = (made / "labels" / about["split"] / name).read_text().splitlines()
        poses = (made / "pose" / "labels" / about["split"] / name).read_text().splitlines()
        seen = [fish for fish in about["fishes"] if fish["pixels"] >= 12]
        assert len(boxes) == len(poses) == len(seen)
        for fish, line, pose in zip(seen, boxes, poses, strict=True):
            _, *box = map(float, line.split())
            assert len(pose.split()) == 5 + 3 * len(NAMES)
            x, y, w, h = fish["box"]
            np.testing.assert_allclose(
                np.array(box) * (96, 72, 96, 72), [x + w / 2, y + h / 2, w, h], atol=1e-3
            )
            assert all(0.0 <= float(one) <= 2.0 for one in pose.split()[5:])
        assert (made / "pose" / "images" / about["split"] / f"{about['image']:07}.jpg").is_file()
    assert "kpt_shape: [14, 3]" in (made / "pose" / "pose.yaml").read_text()
    assert (made / "detect.yaml").read_text().startswith("train: images/train\nval: images/val\n")


def test_yolo_names_a_part_that_is_there_for_both(tmp_path):
    make_dataset(replace(PLAN, val=0.0, maps=()), 1, tmp_path, formats=("yolo",), shard=1)
    for name in ("detect.yaml", "pose/pose.yaml"):
        text = (tmp_path / name).read_text()
        assert text.startswith("train: images/train\nval: images/train\nnames:\n")


@pytest.mark.nightly
def test_fishes_that_the_water_hides_are_not_annotated():
    plan = replace(PLAN, ranges=read_ranges(["water.visibility_cm=60,4000"]), maps=(), per_scene=2)
    seen = {60.0: 0, 4000.0: 0}
    lost = dict(seen)
    for shot in shots(plan, plan.scenario, range(12)):
        visibility = shot.about["visibility_cm"]
        assert visibility == shot.about["scene_values"]["water.visibility_cm"]
        large = [fish for fish in shot.about["fishes"] if fish["pixels"] >= 12]
        kept = annotated(shot.about)
        assert [one for one in large if one["distance_cm"] <= visibility] == kept
        seen[visibility] += len(kept)
        lost[visibility] += len(large) - len(kept)
    assert lost[60.0] > 3  # in murky water
    assert seen[4000.0] > 3 and lost[4000.0] == 0


def test_deeplabcut_has_visible_keypoints_by_animal(made):
    scenes = sorted((made / "deeplabcut" / "labeled-data").iterdir())
    assert [path.name for path in scenes] == ["scene_00000", "scene_00001", "scene_00002"]
    by_image = {f"{about['image']:07}.jpg": about for about, _ in pictures(made)}
    seen = 0
    for folder in scenes:
        with (folder / "CollectedData_subsea.csv").open(newline="") as file:
            heads = [next(file).strip().split(",") for _ in range(4)]
            assert [row[0] for row in heads] == ["scorer", "individuals", "bodyparts", "coords"]
            for row in csv.reader(file):
                assert (folder / row[2]).is_file()
                about = by_image[row[2]]
                for k in range(3, len(row), 2):
                    number = int(heads[1][k].removeprefix("fish"))
                    fish = [one for one in about["fishes"] if one["number"] == number]
                    if row[k]:
                        x, y, state, *_ = fish[0]["keypoints"][NAMES.index(heads[2][k])]
                        assert (float(row[k]), float(row[k + 1]), 2) == (x, y, state)
                        seen += 1
    assert seen > 5


def test_pandas_reads_the_table_as_deeplabcut_does(made):
    path = made / "deeplabcut" / "labeled-data" / "scene_00000" / "CollectedData_subsea.csv"
    table = pandas.read_csv(path, index_col=[0, 1, 2], header=[0, 1, 2, 3])
    assert list(table.columns.names) == ["scorer", "individuals", "bodyparts", "coords"]
    assert table.dtypes.eq(float).all()
    assert set(table.columns.get_level_values("bodyparts")) == set(NAMES)
    assert table.notna().sum().sum() > 0


@pytest.mark.nightly
def test_a_dask_cluster_makes_equal_bytes(made, tmp_path):
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp",
        host="127.0.0.1", dashboard_address="127.0.0.1:0",
    ) as cluster:  # fmt: skip
        make_shards(PLAN, 6, tmp_path, shard=3, pool=dask_pool(cluster.scheduler_address))
    for name in ("00000.tar", "00001.tar"):
        ours, theirs = (folder / "shards" / name for folder in (made, tmp_path))
        assert ours.read_bytes() == theirs.read_bytes()


def test_shards_have_stable_heads(made):
    with tarfile.open(made / "shards" / "00001.tar") as tar:
        infos = tar.getmembers()
    assert {info.mtime for info in infos} == {0}
    assert infos[0].name == "0000003.jpg"
    assert {info.name.split(".", 1)[1] for info in infos} == {
        "jpg", "json", "identity.png", "depth.png", "normal.png", "flow_forward.png",
        "flow_backward.png",
    }  # fmt: skip


def test_the_card_counts_what_is_there(made):
    card = json.loads((made / "card.json").read_text())
    assert sum(card["pictures"].values()) == IMAGES
    total = sum(fish["pixels"] >= 12 for about, _ in pictures(made) for fish in about["fishes"])
    assert sum(card["fishes"].values()) == total
    page = (made / "README.md").read_text()
    assert "Nothing here was compared with real images" in page
    assert "| `water.hour` | 8 to 16 |" in page


def test_a_damaged_shard_is_made_again_and_others_stay(made, capsys):
    before = {path.name: path.read_bytes() for path in (made / "shards").glob("*.tar")}
    whole, hurt = (made / "shards" / f"0000{k}.tar" for k in (0, 2))
    age = whole.stat().st_mtime_ns
    hurt.write_bytes(before[hurt.name][:5000] + b"x" + before[hurt.name][5001:])
    make_shards(PLAN, IMAGES, made, shard=3)
    said = capsys.readouterr().err
    assert said.count("damaged, it is made again") == 1
    assert "00002.tar" in said
    assert whole.stat().st_mtime_ns == age
    assert {path.name: path.read_bytes() for path in (made / "shards").glob("*.tar")} == before


def test_more_images_keep_the_shards(made, tmp_path, monkeypatch):
    jobs = []

    def count(job):
        jobs.append((job.first, job.stop))
        return b""

    monkeypatch.setattr(module, "make_shard", count)
    make_shards(PLAN, 3, tmp_path, shard=3)
    make_shards(PLAN, 7, tmp_path, shard=3)
    assert jobs == [(0, 3), (3, 6), (6, 7)]


def test_another_set_is_not_mixed_in(made):
    other = DatasetPlan(str(BARE), seed=4, size=(96, 72))
    with pytest.raises(UserError, match="holds another set"):
        make_shards(other, 3, made, shard=3)


def test_a_full_disk_is_one_line_and_keeps_finished_shards(tmp_path, monkeypatch):
    def full(path, job, data):
        if job.first:
            raise OSError(28, "No space left on device")
        save(path, job, data)

    save = module._save
    monkeypatch.setattr(module, "make_shard", lambda job: b"data")
    real = module.replacing

    @contextlib.contextmanager
    def small(path):
        with real(path) as temporary:
            if path.name == "00001.tar":
                raise OSError(28, "No space left on device")
            yield temporary

    monkeypatch.setattr(module, "replacing", small)
    with pytest.raises(UserError, match="No space left on device") as fault:
        make_shards(PLAN, 6, tmp_path, shard=3)
    assert "\n" not in str(fault.value)
    assert sorted(path.name for path in (tmp_path / "shards").iterdir()) == [
        "00000.json", "00000.tar",
    ]  # fmt: skip


@pytest.mark.nightly
def test_a_killed_set_continues_with_equal_bytes(made, tmp_path):
    """kill -9 in the middle; another process goes on."""
    command = [
        sys.executable, "-P", "-m", "subsea", "dataset", str(BARE), "--out", str(tmp_path / "set"),
        "--images", "6", "--per-scene", "3", "--shard", "1", "--size", "64x64", "--quality", "low",
        "--seed", "5", "--jobs", "1",
    ]  # fmt: skip
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    end = time.monotonic() + 120
    folder = tmp_path / "set" / "shards"
    while len([*folder.glob("*.tar")]) < 2 and time.monotonic() < end:
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    kept = {path: path.stat().st_mtime_ns for path in folder.glob("[0-9]*.tar")}
    assert 2 <= len(kept) < 6
    done = subprocess.run([*command[:-1], "2"], check=True, capture_output=True, text=True)
    assert done.stdout.strip().endswith("README.md")
    # The last one may lack its checksum.
    assert sum(path.stat().st_mtime_ns == age for path, age in kept.items()) >= len(kept) - 1
    plan = DatasetPlan(str(BARE), seed=5, size=(64, 64), per_scene=3, quality="low")
    for number in (0, 4):
        [shot] = shots(plan, plan.scenario, range(number, number + 1))
        [(about, files)] = read_shard(folder / f"{number:05}.tar")
        assert files["jpg"] == shot.files["jpg"]
        assert about == shot.about


@pytest.mark.nightly
def test_mot_has_sequences_of_one_camera(tmp_path):
    plan = DatasetPlan(
        str(BARE), seed=3, size=(96, 72), per_scene=4, every=1, sequence=True,
        settle_s=(0.5, 1.0), quality="low", val=0.0,
    )  # fmt: skip
    make_dataset(plan, 8, tmp_path, formats=("mot",), shard=3)
    for scene in range(2):
        folder = tmp_path / "mot" / "train" / f"scene_{scene:05}"
        assert len(list((folder / "img1").glob("*.jpg"))) == 4
        assert "seqLength=4" in (folder / "seqinfo.ini").read_text()
        rows = [line.split(",") for line in (folder / "gt" / "gt.txt").read_text().splitlines()]
        assert {row[0] for row in rows} == {"1", "2", "3", "4"}
        assert all(len(row) == 9 for row in rows)
    found = pictures(tmp_path)
    for scene in range(2):
        cameras = [about["camera"] for about, _ in found[4 * scene : 4 * scene + 4]]
        assert all(one == cameras[0] for one in cameras)
        ticks = [about["tick"] for about, _ in found[4 * scene : 4 * scene + 4]]
        assert np.diff(ticks).tolist() == [1, 1, 1]
    assert found[0][0]["camera"] != found[4][0]["camera"]
    [alone] = shots(plan, plan.scenario, range(6, 7))
    assert alone.about == found[6][0]


def test_the_submarine_and_fixed_cameras_take_pictures_too():
    plan = DatasetPlan(
        str(BARE), size=(48, 36), cameras=("submarine", "-400,50,-200,10,-5"), per_scene=6,
        settle_s=(0.2, 0.3), quality="low",
    )  # fmt: skip
    found = [shot.about["camera"]["matrix"] for shot in shots(plan, plan.scenario, range(6))]
    eyes = {tuple(np.round(np.linalg.inv(one)[:3, 3], 3)) for one in found}
    assert (-400.0, 50.0, -200.0) in eyes
    assert len(eyes) > 1


def test_a_new_range_leaves_other_values_as_they_are():
    few, more = read_ranges(["water.hour=6:18"]), read_ranges(["water.hour=6:18", "a.b=1:2"])
    for number in range(5):
        one, other = (drawn(ranges, (1, 2, number)) for ranges in (few, more))
        assert one["water.hour"] == other["water.hour"]


def test_ranges_of_a_file_are_read(tmp_path):
    path = tmp_path / "ranges.toml"
    path.write_text('"water.hour" = "6:18"\nwater.type = ["I", "III"]\n[sensor]\nnoise = "0:4"\n')
    found = read_ranges(["sensor.noise=1:2"], path)
    assert found["water.hour"] == DrawnRange("water.hour", 6.0, 18.0)
    assert found["water.type"].choices == ("I", "III")
    assert found["sensor.noise"].high == 2.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--images", "0"], "--images"),
        (["--images", "5", "--format", "coco,yollo"], "unknown format 'yollo'; did you mean"),
        (["--images", "5", "--maps", "deph"], "unknown map 'deph'"),
        (["--images", "5", "--vary", "water.hours=6:18"], "water.hour"),
        (["--images", "5", "--vary", "sensor.nois=1:2"], "sensor.noise"),
        (["--images", "5", "--vary", "water.hour=6:30"], "24"),
        (["--images", "5", "--vary", "water.hour=18:6"], "LOW below HIGH"),
        (["--images", "5", "--vary", "water.hour"], "KEY=LOW:HIGH"),
        (["--images", "5", "--vary", "jpeg.quality=0:200"], "expected 1 to 100"),
        (["--images", "5", "--vary", "camera.lamps=perhaps"], "expected a number"),
        (["--images", "5", "--camera", "100,0,-400,0,0"], "is inside a stone"),
        (["--images", "5", "--camera", "here"], "X,Y,Z,HEADING,PITCH"),
        (["--images", "5", "--ranges", "none.toml"], "no such file"),
    ],
)
def test_bad_input_is_one_line(options, message, tmp_path, capsys):
    with contextlib.suppress(SystemExit):
        assert main(["dataset", str(BARE), "--out", str(tmp_path / "set"), *options]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert message in said[-1]
    assert not (tmp_path / "set").exists()
