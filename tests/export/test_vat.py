"""Our files, read by a decoder of OpenVAT, compared with playback."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from PIL import Image

from subsea.export.clips import Clip, Model, make_clips, transform_points
from subsea.export.conventions import Y_UP, to_metres
from subsea.export.vat import png16, write_vat
from subsea.geometry.rotation import matrix
from subsea.rendering.gl.context import headless_context
from tests.export.conftest import exported
from tests.support.daily import only
from tests.support.gltf_reader import Reader


class Decoded:
    """The folder, read as OpenVAT-Engine_Tools/GLSL/VertexAnimationPBR-GLSL.gdshader does."""

    def __init__(self, folder: Path, name: str) -> None:
        import trimesh

        self.info = json.loads((folder / f"{name}-remap_info.json").read_text())
        self.ranges = self.info["os-remap"]
        texels = cv2.imread(str(folder / f"{name}_vat.png"), cv2.IMREAD_UNCHANGED)
        assert texels is not None and texels.dtype == np.uint16
        self.texels = texels[..., ::-1] / 65535.0
        self.mesh = trimesh.load(folder / f"{name}.glb", force="mesh", process=False)
        file = Reader(folder / f"{name}.glb")
        [primitive] = file.content["meshes"][0]["primitives"]
        self.uv2 = file.array(primitive["attributes"]["TEXCOORD_1"])

    def at(self, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """Points and normals (n, 3) of a frame, counted from 0: metres, y up."""
        height, width, _ = self.texels.shape
        column = (self.uv2[:, 0] * width).astype(int)
        row = ((self.uv2[:, 1] + frame / height) * height).astype(int)
        low, high = np.array(self.ranges["Min"]), np.array(self.ranges["Max"])
        way = low + self.texels[row, column] * (high - low)
        normal = 2.0 * self.texels[row + height // 2, column] - 1.0
        return self.mesh.vertices + _y_up(way), _y_up(normal)


def _y_up(blender: np.ndarray) -> np.ndarray:
    return np.stack([blender[:, 0], blender[:, 2], -blender[:, 1]], axis=1)


# The widest ranges and the longest fishes; OpenUSD reads all of them (`test_usd.py`).
@pytest.mark.nightly
@pytest.mark.parametrize(
    "known",
    only(
        ("fusilier",),
        ("fusilier", "blue_tang", "blacktip_reef_shark", "ribbon_eel", "spotted_eagle_ray"),
    ),
)
def test_decoded_frames_equal_playback(known: str, tmp_path: Path) -> None:
    """Within half a step of 16 bits: 1.5e-5 body lengths of far escapes, and 0.002 degrees."""
    model, clips = exported(known)
    for path in write_vat(tmp_path, model, clips, baked=False):
        assert path.is_file()
    read = Decoded(tmp_path / f"{known}_vat", known)
    height, width, _ = read.texels.shape
    assert width == len(model.rest) and height == 2 * read.ranges["Frames"]
    assert list(read.info["animations"]) == [clip.name for clip in clips]
    frames = 0
    for clip in clips:
        track = read.info["animations"][clip.name]
        assert track["startFrame"] == frames + 1
        assert track["endFrame"] == frames + len(clip.points)
        assert track["looping"] == clip.cyclic
        _compare(read, frames, model, clip.points, clip.normals, 1.5e-5)
        frames += len(clip.points)
    assert frames == read.ranges["Frames"]


@pytest.mark.nightly
@pytest.mark.parametrize("name", only(["spotted_eagle_ray"], ["fusilier", "spotted_eagle_ray"]))
def test_the_root_may_be_baked(name: str, tmp_path: Path) -> None:
    model, clips = exported(name)
    write_vat(tmp_path, model, clips, baked=True)
    read = Decoded(tmp_path / f"{name}_vat", name)
    assert "root" not in read.info["subsea"]
    frames = 0
    for clip in clips:
        points = transform_points(clip.points, clip.position, clip.rotation)
        normals = clip.normals @ np.swapaxes(matrix(clip.rotation), 1, 2)
        _compare(read, frames, model, points, normals, 6e-5)
        frames += len(clip.points)


def _compare(
    read: Decoded, first: int, model: Model, points: np.ndarray, normals: np.ndarray, bound: float
) -> None:
    """Every third frame, and the last."""
    for frame in {*range(0, len(points), 3), len(points) - 1}:
        found, facing = read.at(first + frame)
        off = np.linalg.norm(found - to_metres(points[frame], Y_UP), axis=1)
        assert off.max() < bound * 0.01 * model.length_cm
        assert np.abs(facing - normals[frame] @ Y_UP.T).max() < 2e-5


def test_the_root_motion_is_in_the_axes_of_the_texture(tmp_path: Path) -> None:
    model, every = exported("fusilier")
    clips = every[::4]
    write_vat(tmp_path, model, clips, baked=False)
    read = Decoded(tmp_path / f"{model.name}_vat", model.name)
    own = read.info["subsea"]
    assert own["framesPerSecond"] == pytest.approx(clips[0].fps)
    assert own["bodyLength"] == pytest.approx(0.01 * model.length_cm)
    first = 0
    for clip in clips:
        root = own["root"][clip.name]
        frame = len(clip.points) - 1
        points, _ = read.at(first + frame)
        z_up = np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)
        moved = z_up @ matrix(np.array(root["rotation"][frame])).T + root["position"][frame]
        expected = transform_points(clip.points, clip.position, clip.rotation)[frame]
        np.testing.assert_allclose(
            _y_up(moved), to_metres(expected, Y_UP), atol=1.5e-5 * own["bodyLength"]
        )
        first += len(clip.points)


@pytest.fixture(scope="module")
def own() -> tuple[Model, list[Clip]]:
    """Called as a species of one's own may be."""
    model, clips = make_clips("spotted_eagle_ray", detail=2)
    return model._replace(name="mein-Fisch_ä"), clips


def test_the_validator_has_no_objection(
    khronos: Callable[[Path], dict[str, Any]], own: tuple[Model, list[Clip]], tmp_path: Path
) -> None:
    issues = khronos(write_vat(tmp_path, *own, baked=False)[2])["issues"]
    assert issues["numErrors"] == issues["numWarnings"] == 0, issues


def test_other_readers_read_the_mesh_and_the_texture(
    own: tuple[Model, list[Clip]], tmp_path: Path
) -> None:
    import trimesh

    model, clips = own
    vat, colours, mesh, _ = write_vat(tmp_path, model, clips, baked=False)
    read = trimesh.load(mesh, force="mesh", process=False)
    np.testing.assert_allclose(read.vertices, to_metres(model.rest, Y_UP), atol=1e-6)
    np.testing.assert_array_equal(read.faces, model.triangles)
    np.testing.assert_allclose(read.visual.uv, model.uv, atol=1e-6)  # trimesh turns v back
    with Image.open(colours) as picture:
        np.testing.assert_array_equal(np.asarray(picture)[::-1], model.sheet)
    with Image.open(vat) as picture:
        assert picture.size == (len(model.rest), 2 * sum(len(clip.points) for clip in clips))


def test_a_16_bit_picture_is_read_back_unchanged(tmp_path: Path) -> None:
    texels = np.random.default_rng(7).integers(0, 65536, (5, 7, 3)).astype(np.uint16)
    kept = texels.copy()
    (tmp_path / "noise.png").write_bytes(png16(texels))
    read = cv2.imread(str(tmp_path / "noise.png"), cv2.IMREAD_UNCHANGED)
    assert read is not None
    np.testing.assert_array_equal(read[..., ::-1], kept)
    np.testing.assert_array_equal(texels, kept)


@pytest.mark.nightly
def test_the_shader_of_the_documentation_decodes_it(tmp_path: Path) -> None:
    """Run as it is printed, on a texture of 16 bits."""
    text = (Path(__file__).parents[2] / "docs/developers/export-figures.md").read_text(
        encoding="utf-8"
    )
    body = text.partition("```glsl\n")[2].partition("```")[0]
    model, clips = make_clips("fusilier", detail=2)
    write_vat(tmp_path, model, clips, baked=False)
    read = Decoded(tmp_path / "fusilier_vat", "fusilier")
    height, width, _ = read.texels.shape
    with headless_context() as gl:
        gl.simple_framebuffer((1, 1)).use()  # a context without a window has none of its own
        program = gl.program(
            vertex_shader=f"""#version 330
                uniform sampler2D vat; uniform vec3 low, high; uniform float frame, height;
                in vec3 rest; in vec2 uv2; out vec3 position, normal;
                void main() {{ position = rest; {body} }}""",
            varyings=("position", "normal"),
        )
        values = np.round(65535.0 * read.texels).astype("u2")
        # The first row is at v = 0, as in glTF.
        texture = gl.texture((width, height), 3, values.tobytes(), alignment=2, dtype="nu2")
        texture.filter = (gl.NEAREST, gl.NEAREST)
        texture.use()
        vertices = np.concatenate([read.mesh.vertices, read.uv2], axis=1).astype("f4")
        array = gl.vertex_array(program, gl.buffer(vertices.tobytes()), "rest", "uv2")
        out = gl.buffer(reserve=24 * len(vertices))
        program["low"], program["high"] = read.ranges["Min"], read.ranges["Max"]
        program["frame"], program["height"] = 40.0, float(height)
        array.transform(out, gl.POINTS)
        found = np.frombuffer(out.read(), "f4").reshape(-1, 6)
    gl.release()
    points, normals = read.at(40)
    np.testing.assert_allclose(found[:, :3], points, atol=1e-7)
    np.testing.assert_allclose(found[:, 3:], normals, atol=1e-4)
