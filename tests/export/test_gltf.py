"""Exported glTF, played by a reader of its own that follows the specification word for word."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from capture.cli.main import main
from subsea.export import MESHOPT, QUANTISED
from subsea.export.clips import Clip, Model, all_points, make_clips, transform_points
from subsea.export.conventions import Y_UP, sheet_png, to_metres
from subsea.export.glb import packing_of
from subsea.export.gltf import write_gltf
from subsea.export.skinning import MAX_INFLUENCES, Skeleton, best_shares, fit_skeleton, refit
from tests.support.gltf_reader import Reader

RMS_PERCENT, MOST_PERCENT = 0.2, 2.0  # of the body length: what fitted joints may be off ...
# ... and those of species with long fins that wave, in all of their segments.
WAVING = {
    "blue_tang": (0.21, 4.6), "bluecheek_butterflyfish": (0.2, 3.6),
    "clownfish": (0.2, 2.8), "emperor_angelfish": (0.21, 2.1),
}  # fmt: skip
BAKED = ["fusilier", "spotted_eagle_ray"]  # species that are also exported with a baked root
# The widest motions; at night all are fitted, which takes ten times as long.
WIDEST = "swim_fast", "swim_burst", "turn_left_sharp", "cstart_left_wide", "swim_stop"
ROUNDED_PERCENT = 0.1  # that rounding may add, nearly all by weights of 8 bits
EXACT_PERCENT = 1e-3  # single precision, some lengths from the origin
Exported = tuple[Model, list[Clip], Skeleton]


@pytest.fixture(scope="module")
def fitted(known: str, pytestconfig: pytest.Config) -> Exported:
    """A species at the coarsest level, which has few vertices to fit."""
    model, clips = make_clips(known, 3)
    if not pytestconfig.getoption("--nightly"):
        clips = [clip for clip in clips if clip.name in WIDEST]
    return model, clips, fit_skeleton(model, all_points(clips))


@pytest.fixture(scope="module")
def files(fitted: Exported, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """With joints, and with morph targets."""
    return _written(fitted, tmp_path_factory, baked=False)


@pytest.fixture(scope="module")
def baked(fitted: Exported, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The same with the way of the root in what it carries."""
    return _written(fitted, tmp_path_factory, baked=True)


def _written(fitted: Exported, folders: pytest.TempPathFactory, baked: bool) -> tuple[Path, Path]:
    model, clips, rig = fitted
    joints, morphed = (folders.mktemp(name) for name in ("joints", "morphed"))
    return (
        write_gltf(joints, model, clips, baked, rig),
        write_gltf(morphed, model, clips, baked, None),
    )


def off_percent(reader: Reader, model: Model, clip: Clip, step: float = 0.0) -> np.ndarray:
    """Distance of the vertices from playback, at all keys or `step` of the way to the next."""
    points = transform_points(clip.points, clip.position, clip.rotation)
    if step:
        points = (1 - step) * points[:-1] + step * points[1:]
    times = reader.times(clip.name)
    assert len(times) == len(clip.points)
    assert times[-1] == pytest.approx((len(clip.points) - 1) / clip.fps)
    found = reader.points(clip.name, times[: len(points)] + step * (times[-1] / (len(times) - 1)))
    far = np.linalg.norm(found - to_metres(points, Y_UP), axis=2)
    return 1e4 * far / model.length_cm


def sound(report: dict[str, Any]) -> bool:
    """True if the validator of Khronos finds nothing to object to."""
    issues = report["issues"]
    return issues["numErrors"] == issues["numWarnings"] == 0


def test_joints_move_the_mesh_as_playback_does(
    known: str, fitted: Exported, files: tuple[Path, Path]
) -> None:
    """Whole segments, with the path of the root; the reported error is correct."""
    rms_percent, most_percent = WAVING.get(known, (RMS_PERCENT, MOST_PERCENT))
    model, clips, rig = fitted
    reader = Reader(files[0])
    off = np.concatenate([off_percent(reader, model, clip) for clip in clips])
    assert np.sqrt((off**2).mean()) == pytest.approx(rig.rms_percent, rel=0.01)
    assert off.max() == pytest.approx(rig.most_percent, rel=0.01)
    assert rig.rms_percent < rms_percent and rig.most_percent < most_percent
    said = reader.content["asset"]["extras"]
    assert (said["rmsErrorPercent"], said["maxErrorPercent"]) == (rig.rms_percent, rig.most_percent)
    assert off_percent(reader, model, clips[-1], 0.5).max() < most_percent
    # The weights and joints are those of a rigid skeleton.
    assert (rig.weights >= 0.0).all()
    np.testing.assert_allclose(rig.weights.sum(axis=1), 1.0, atol=1e-9)
    assert ((rig.weights > 0.0).sum(axis=1) <= MAX_INFLUENCES).all()
    np.testing.assert_allclose(np.linalg.det(rig.motion[..., :3]), 1.0)
    assert len(rig.joints) <= 30


@pytest.mark.nightly
def test_levels_are_other_meshes_on_the_same_joints(
    tmp_path: Path, khronos: Callable[[Path], dict[str, Any]]
) -> None:
    """Beside the scene: a reader that does not know levels shows the finest one alone."""
    (fine, clips), (coarse, moved) = (make_clips("fusilier", detail) for detail in (2, 3))
    clips, moved = ([one for one in many if one.name == "swim_fast"] for many in (clips, moved))
    rig = fit_skeleton(fine, all_points(clips))
    bound = refit(coarse, rig, all_points(moved))
    assert bound.rms_percent < 2.0 * rig.rms_percent
    path = write_gltf(tmp_path, fine, clips, False, rig, levels=[(coarse, bound)])
    assert sound(khronos(path))
    reader = Reader(path)
    content = reader.content
    names = [node.get("name") for node in content["nodes"]]
    first, second = names.index("fusilier_LOD0"), names.index("fusilier_LOD1")
    assert content["nodes"][first]["extensions"]["MSFT_lod"]["ids"] == [second]
    coverage = content["nodes"][first]["extras"]["MSFT_screencoverage"]
    assert len(coverage) == 2 and coverage[0] > coverage[1]
    assert first in content["scenes"][0]["nodes"] and second not in content["scenes"][0]["nodes"]
    assert "MSFT_lod" not in content.get("extensionsRequired", [])
    times = reader.times("swim_fast")
    moment = reader.worlds("swim_fast", times)
    found, _ = reader.node_points(second, moment)
    goal = transform_points(moved[0].points, moved[0].position, moved[0].rotation)
    off = 1e4 * np.linalg.norm(found - to_metres(goal, Y_UP), axis=2) / coarse.length_cm
    assert np.sqrt((off**2).mean()) == pytest.approx(bound.rms_percent, rel=0.01)
    looks = [
        [part["material"] for part in content["meshes"][content["nodes"][k]["mesh"]]["primitives"]]
        for k in (first, second)
    ]
    assert set(looks[1]) <= set(looks[0])
    assert len(content["images"]) == 3  # colours, metal and scales


def test_morph_targets_are_exact(fitted: Exported, files: tuple[Path, Path]) -> None:
    model, clips, _ = fitted
    reader = Reader(files[1])
    for clip in clips[::3]:
        assert off_percent(reader, model, clip).max() < EXACT_PERCENT
    # Between two frames our points go straight: a chord of the arc that a root turns in.
    assert off_percent(reader, model, clips[0], 0.5).max() < 0.3


@pytest.mark.nightly
def test_the_validator_has_no_objection(
    known: str,
    fitted: Exported,
    files: tuple[Path, Path],
    khronos: Callable[[Path], dict[str, Any]],
    request: pytest.FixtureRequest,
) -> None:
    _, clips, _ = fitted
    baked = request.getfixturevalue("baked") if known in BAKED else ()
    for path in (*files, *baked):
        report = khronos(path)
        assert sound(report)
        assert report["info"]["animationCount"] == len(clips)


@pytest.mark.parametrize("known", BAKED, indirect=True)
def test_the_path_can_be_baked_into_joints_and_targets(
    fitted: Exported, baked: tuple[Path, Path]
) -> None:
    """Nothing moves the root then."""
    model, clips, rig = fitted
    for path, least in zip(baked, (rig.most_percent + EXACT_PERCENT, EXACT_PERCENT), strict=True):
        reader = Reader(path)
        assert reader.content["asset"]["extras"]["root"] == "baked"
        for clip in (clips[1], clips[-1]):
            assert off_percent(reader, model, clip).max() < least
            moved = [one["target"] for one in reader.animations[clip.name]["channels"]]
            assert not [one for one in moved if one["node"] == 0 and one["path"] != "weights"]


def test_a_cycle_ends_as_it_began(fitted: Exported, files: tuple[Path, Path]) -> None:
    """To the last bit; only the root has moved on."""
    model, clips, _ = fitted
    for path in files:
        reader = Reader(path)
        for clip in clips:
            one = reader.animations[clip.name]
            assert one["extras"]["loop"] == clip.cyclic
            for channel in one["channels"]:
                keys = reader.array(one["samplers"][channel["sampler"]]["output"])
                keys = keys.reshape(len(clip.points), -1)
                what = channel["target"]["path"]
                if channel["target"]["node"] == 0 and what != "weights":
                    assert what == "rotation" or (keys[0] != keys[-1]).any()
                elif clip.cyclic:
                    np.testing.assert_array_equal(np.abs(keys[0]), np.abs(keys[-1]))
            assert reader.content["nodes"][0]["name"] in ("root", model.name)


@pytest.mark.nightly
@pytest.mark.parametrize("known", BAKED[:1], indirect=True)
@pytest.mark.parametrize("kind", [QUANTISED, MESHOPT])
def test_compressed_files_play_alike(
    kind: str,
    fitted: Exported,
    files: tuple[Path, Path],
    opened: Callable[[Path], Reader],
    khronos: Callable[[Path], dict[str, Any]],
    tmp_path: Path,
) -> None:
    """And are smaller, with joints and with morph targets."""
    model, clips, rig = fitted
    for k, skeleton in enumerate((rig, None)):
        path = write_gltf(tmp_path, model, clips, False, skeleton, packing_of(kind))
        assert sound(khronos(path))
        reader = opened(path)
        most = ROUNDED_PERCENT + (rig.most_percent if skeleton else 0.0)
        for clip in clips[::4]:
            assert off_percent(reader, model, clip).max() < most
        sizes = [file.stat().st_size - len(sheet_png(model.sheet)) for file in (path, files[k])]
        assert sizes[0] < (0.95, 0.65)[k] * sizes[1]


def test_weights_are_optimal() -> None:
    """Where all may be used, by the conditions of Karush, Kuhn and Tucker."""
    rng = np.random.default_rng(3)
    for _ in range(50):
        rows = rng.normal(size=(9, 6)) + rng.normal(size=(9, 1))
        gram = rows.T @ rows
        best = best_shares(gram, 6)
        slope = gram @ best
        assert best.sum() == pytest.approx(1.0) and (best >= 0.0).all()
        assert (slope >= best @ slope - 1e-4 * np.trace(gram)).all()
        few = best_shares(gram, 2)
        assert (few > 0.0).sum() <= 2
        pairs = [
            min((1 - t) ** 2 * gram[i, i] + 2 * t * (1 - t) * gram[i, j] + t * t * gram[j, j]
                for t in np.linspace(0, 1, 101))
            for i in range(6) for j in range(i)
        ]  # fmt: skip
        assert few @ gram @ few <= np.median(pairs)


@pytest.mark.nightly
def test_from_the_command_line_to_trimesh(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """At the finest level; the sheet, three materials and both sides of fins come along."""
    assert main(["export", "fusilier", "--to", "gltf", "--out", str(tmp_path)]) == 0
    [line] = capsys.readouterr().out.splitlines()
    path = tmp_path / "fusilier.glb"
    size = f"{path.stat().st_size / 1e6:.1f} MB"
    assert line.startswith(f"{path}: {size}, 28 joints; vertices are off by 0.1")
    said = Reader(path).content["asset"]["extras"]
    assert said["rmsErrorPercent"] < RMS_PERCENT and said["maxErrorPercent"] < MOST_PERCENT
    model, clips = make_clips("fusilier")
    import trimesh

    scene = trimesh.load(path)
    [body, clear, fins] = (scene.geometry[name] for name in sorted(scene.geometry))
    parts = [len(part.faces) for part in (body, clear, fins)]
    assert sum(parts) == len(model.triangles) and parts[2] == len(model.triangles) - model.body
    low, high = scene.bounds
    np.testing.assert_allclose(high - low, np.ptp(to_metres(model.rest, Y_UP), axis=0), atol=1e-6)
    looks = [part.visual.material for part in (body, clear, fins)]
    assert [look.alphaMode for look in looks] == [None, "BLEND", "BLEND"]
    assert [look.doubleSided for look in looks] == [False, False, True]
    np.testing.assert_array_equal(np.asarray(looks[0].baseColorTexture), model.sheet[::-1])
    assert main(["export", "fusilier", "--to", "gltf", "--morph", "--out", str(tmp_path)]) == 0
    size = f"{path.stat().st_size / 1e6:.1f} MB"
    assert f"fusilier.glb: {size}, exact" in capsys.readouterr().out
    assert off_percent(Reader(path), model, clips[-1]).max() < 1e-3
