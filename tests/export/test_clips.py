"""Clips are the recorded segments, on the surface of `tests/rendering/fish/test_fishes.py`."""

from pathlib import Path

import numpy as np
import pytest

from capture.inspection.simulated import replay
from subsea.base.errors import UserError
from subsea.base.system import resource_path
from subsea.export.clips import (
    Clip,
    Model,
    Surface,
    at_rate,
    make_clips,
    root_motion,
    transform_points,
)
from subsea.export.fin_motion import FinPlayer
from subsea.fish import sheet_layout
from subsea.fish.mesh import DETAILS, fish_mesh
from subsea.fish.species import load_species
from subsea.geometry.rotation import matrix
from subsea.repertoire import read_repertoire
from subsea.repertoire.library import pack
from subsea.world.repertoires import coupling_of
from tests.support.daily import only


def test_each_frame_is_a_row_of_the_playback_table(
    known: str, model: Model, clips: list[Clip]
) -> None:
    """As large as the usual adult, and as slow as that one is."""
    species = load_species(known)
    repertoire = read_repertoire(resource_path(f"repertoires/{known}.h5"))
    library = pack([repertoire], [coupling_of(species, repertoire)])
    surface = Surface(species, repertoire.body_length_cm, 0)
    scale = np.mean(species.size_cm) / repertoire.body_length_cm
    assert [clip.name for clip in clips] == repertoire.recorded_names()
    table = library.first[0], library.length[0], library.has[0]
    recorded = [(first, rows) for first, rows, has in zip(*table, strict=True) if has]
    fins = FinPlayer(species, repertoire, scale)
    for clip, (first, rows) in zip(clips, recorded, strict=True):
        beats, moved = fins.clip(clip.name)
        assert clip.beats == beats and (clip.cyclic or beats == 1)
        frames = beats * rows
        assert len(clip.points) == len(clip.position) == len(moved) == frames + clip.cyclic
        last = slice(frames - rows, frames)  # the last beat, in which fins are elsewhere
        shown = surface.at(library.control_points[first : first + rows], moved[last])
        np.testing.assert_allclose(clip.points[last], scale * shown[0], atol=1e-4 * scale)
        np.testing.assert_allclose(clip.normals[last], shown[1], atol=0.02)
        assert clip.fps == pytest.approx(species.pace / (repertoire.tick_s * np.sqrt(scale)))
        if clip.cyclic:
            np.testing.assert_array_equal(clip.points[-1], clip.points[0])
    assert np.ptp(model.rest[:, 0]) == pytest.approx(np.mean(species.size_cm), rel=0.05)


def test_the_root_goes_where_playback_takes_the_fish(known: str) -> None:
    """Two beats of playback, from whatever was before the first row."""
    repertoire = read_repertoire(resource_path(f"repertoires/{known}.h5"))
    for segment in repertoire.segments.values():
        beats = 2 if segment.cyclic else 1
        played = replay(segment, np.zeros(3), np.eye(3), beats)
        position, rotation = root_motion(segment, beats)
        rows = [*range(len(segment.nodes)), *([0] if segment.cyclic else [])]
        rows = (rows[:-1] * beats)[: len(played)] if segment.cyclic else rows
        position, rotation = position[: len(rows)], rotation[: len(rows)]
        found = transform_points(segment.nodes[rows], position, rotation)
        first = matrix(segment.increment_rotation[0])
        seen = (played[: len(rows)] - segment.increment_translation[0]) @ first
        np.testing.assert_allclose(found, seen, atol=1e-6 * repertoire.body_length_cm)
        np.testing.assert_array_equal(position[0], 0.0)
        np.testing.assert_array_equal(rotation[0], (1.0, 0.0, 0.0, 0.0))
        assert ((rotation[1:] * rotation[:-1]).sum(axis=1) > 0.9).all()


def test_the_mesh_is_whole(known: str, model: Model) -> None:
    """No vertex is of a fin that is not there, no triangle without area or inside out."""
    plan = load_species(known).surface
    assert set(model.triangles.ravel()) == set(range(len(model.rest)))
    assert model.triangles[: model.body].max() < model.solid <= model.triangles[model.body :].min()
    assert ((model.uv >= 0.0) & (model.uv <= 1.0)).all()
    np.testing.assert_allclose(np.linalg.norm(model.normals, axis=1), 1.0, atol=1e-6)
    a, b, c = (model.rest[model.triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    assert ((across**2).sum(axis=1) > 0.0).all()
    outward = (across * model.normals[model.triangles].sum(axis=1)).sum(axis=1) > 0.0
    assert outward[model.body :].all()
    assert outward.mean() > 0.98  # the edge of a wing is thinner than its triangles are wide
    volume = (a * across).sum(axis=1)[: model.body].sum() / 6.0
    assert volume > 0.0
    pairs = 2 * ((plan.pectoral is not None) + (plan.pelvic is not None))
    fins = pairs + (plan.dorsal is not None) + (plan.ventral is not None)
    assert _pieces(model.triangles[model.body :]) == fins


def _pieces(triangles: np.ndarray) -> int:
    """Count connected parts."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    _, number = np.unique(triangles, return_inverse=True)
    a, b, c = number.reshape(-1, 3).T
    ends = np.concatenate([a, b]), np.concatenate([b, c])
    graph = coo_array((np.ones(len(ends[0])), ends), shape=(number.max() + 1,) * 2)
    return int(connected_components(graph, directed=False)[0])


@pytest.mark.parametrize("detail", only([1, 3], range(len(DETAILS))))
def test_coarser_levels_have_fewer_vertices(detail: int) -> None:
    model, clips = make_clips("fusilier", detail)
    assert len(model.rest) == len(fish_mesh(DETAILS[detail]).vertices)
    assert clips[0].points.shape[1:] == model.rest.shape
    assert set(model.triangles.ravel()) <= set(range(len(model.rest)))


def test_a_species_that_is_unknown_or_unrecorded_is_one_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    with pytest.raises(UserError, match="did you mean 'fusilier'"):
        make_clips("fusiler")
    nowhere = tmp_path / "fusilier.h5"
    monkeypatch.setattr("subsea.export.clips.repertoire_file", lambda name: nowhere)
    with pytest.raises(UserError, match=r"fusilier.h5: no such file; run `subsea-capture rec"):
        make_clips("fusilier")


@pytest.mark.parametrize("fps", [24.0, 25.0, 60.0])
def test_a_clip_at_another_rate_goes_the_same_way(fps: float) -> None:
    """It begins and ends as before, at most half a frame earlier or later."""
    turn = np.linspace(0.0, 2.0 * np.pi, 41)
    circle = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)[:, None]
    still = np.tile([1.0, 0.0, 0.0, 0.0], (41, 1))
    clip = Clip(
        "swim_fast", 27.4, True, circle, circle, 3.0 * turn[:, None] * np.eye(3)[0], still, 1
    )
    found = at_rate(clip, fps)
    frames = len(found.points) - 1
    assert found.fps == fps and abs(frames / fps - 40 / 27.4) <= 0.5 / fps + 1e-9
    np.testing.assert_allclose(found.points[[0, -1]], circle[[0, -1]], atol=1e-12)
    np.testing.assert_allclose(found.position[-1], clip.position[-1])
    np.testing.assert_allclose(np.diff(found.position[:, 0]), 6.0 * np.pi / frames)
    np.testing.assert_allclose(np.linalg.norm(found.points, axis=2), 1.0, atol=0.004)  # chords
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=2), 1.0)
    same = at_rate(clip, 27.4)
    np.testing.assert_allclose(same.points, clip.points, atol=1e-12)


SHEET = {"dorsal": sheet_layout.DORSAL, "pectoral_left": sheet_layout.PECTORAL}


def test_skin_lies_where_the_sheet_has_it(known: str, model: Model) -> None:
    """On the sheet a body is seen from its side: skin.md says where."""
    species = load_species(known)
    for name in SHEET.keys() & model.fins.keys():
        place = SHEET[name]
        low, high = model.uv[model.fins[name]].min(axis=0), model.uv[model.fins[name]].max(axis=0)
        assert (low >= place[:2]).all() and (high <= place[2:]).all(), name
    if species.surface.wing is not None or species.form == "flatfish":
        return  # a disc is unfolded, and a flatfish lies
    ahead, up = model.rest[: model.solid, 0], model.rest[: model.solid, 1]
    left, right = sheet_layout.borders(species.surface)
    half = sheet_layout.half_height(species.surface)
    along = (ahead.max() - ahead) / model.length_cm
    wanted = np.stack([(along - left) / (right - left), 0.4 + 0.4 * up / model.length_cm / half], 1)
    assert np.abs(model.uv[: model.solid] - wanted).max() < 0.02
