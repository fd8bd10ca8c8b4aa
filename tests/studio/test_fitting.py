"""Meshes find the fish in a photograph by themselves."""

from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from msgspec import structs

from subsea.base.errors import UserError
from subsea.base.system import resource_path
from subsea.fish import sheet_layout
from subsea.fish.outline_file import read_outline
from subsea.fish.species import load_species
from subsea.studio.deformable_mesh import copy_meshes, transform
from subsea.studio.dress import GOOD
from subsea.studio.fitting import (
    align_shape,
    fin_errors,
    find_fish,
    outline_error,
    segment_under,
    silhouette,
)
from subsea.studio.lift import lift_sheet, mesh_mask
from subsea.studio.photograph import Photograph, read_photograph
from subsea.studio.side_view import (
    centred_matrix,
    make_fish_meshes,
    mesh_outlines,
    side_view,
    to_picture,
)


# The worst of all, which heads right, and a faint one; the script itself bounds the others.
@pytest.mark.nightly
@pytest.mark.parametrize("name", ["black and white, reef", "low contrast, shark"])
def test_outlines_are_found(accuracy, name):
    case = accuracy.CASES[name]
    photograph, truth, _ = accuracy.made(case)
    one = find_fish(photograph, load_species(case.species).surface)
    assert outline_error(one.meshes, truth) < accuracy.MOST
    head, tail = one.meshes.body.nodes[4, [0, -1], 0]
    assert (head > tail) == case.right


def test_the_table_fails_where_an_outline_is_off_too_far(accuracy, clownfish_photo, monkeypatch):
    monkeypatch.setattr(accuracy, "CASES", {"one": accuracy.Case("clownfish")})
    monkeypatch.setattr(accuracy, "made", lambda case: clownfish_photo)
    monkeypatch.setattr(
        accuracy, "find_fish", lambda photograph, plan: SimpleNamespace(meshes=None)
    )
    monkeypatch.setattr(accuracy, "border_error", lambda *_: 0.5)
    monkeypatch.setattr(accuracy, "fin_errors", lambda *_: {"dorsal": 0.5})
    monkeypatch.setattr("sys.argv", ["skin_accuracy.py"])
    for off, code in ((0.0149, 0), (0.0151, 1), (np.nan, 1)):
        monkeypatch.setattr(accuracy, "outline_error", lambda *_, off=off: off)
        assert accuracy.main() == code


@pytest.mark.parametrize("name", ["fusilier", "bluecheek_butterflyfish"])
@pytest.mark.parametrize("tilt, right", [(0.0, False), (20.0, True), (-35.0, False)])
def test_shapes_are_laid_over_masks(name, tilt, right):
    plan = load_species(name).surface
    tilt = np.radians(tilt)
    turn = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]])
    matrix = np.column_stack(
        [190.0 * turn @ np.diag([-1.0 if right else 1.0, -1.0]), (300.0 if right else 130.0, 200)]
    )
    mask = silhouette(plan, matrix, (400, 440))
    got, likeness = align_shape(plan, mask)
    assert likeness > 0.93
    both = silhouette(plan, got, mask.shape)
    assert (both & mask).sum() > 0.93 * (both | mask).sum()
    assert (got[0, 0] < 0) == right
    other, less = align_shape(plan, mask, heads_right=not right)
    assert (other[0, 0] > 0) == right and less < likeness


@pytest.fixture(scope="module")
def found_clownfish(clownfish_photo):
    """The fish in the photograph of a clownfish; copy its meshes before you move them."""
    return find_fish(clownfish_photo.photograph, load_species("clownfish").surface)


def test_opacity_segments_the_fish(clownfish_photo):
    photograph, truth, _ = clownfish_photo
    plan = load_species("clownfish").surface
    # Colours cannot help here: the picture is grey.
    cut = photograph._replace(
        colour=np.full_like(photograph.colour, 90), opacity=np.where(truth, 255, 0).astype(np.uint8)
    )
    assert outline_error(find_fish(cut, plan).meshes, truth) < 0.01


@pytest.mark.nightly
def test_the_shipped_photograph_dresses_the_tuna_of_its_outline():
    """A real fish: its dark back, the blue line below, its white flank and its eye come out."""
    outlines = resource_path("docs/outlines")
    photograph = read_photograph(outlines / "tuna.webp")
    surface = read_outline(outlines / "tuna.toml", None, None)
    found = find_fish(photograph, surface)
    assert found.likeness > 0.85
    assert outline_error(found.meshes, photograph.opacity > 127) < 0.01
    fusilier = load_species("fusilier")
    skin = structs.replace(fusilier.skin, dorsal=None, ventral=None)
    tuna = structs.replace(fusilier, surface=surface, skin=skin)
    sheet = lift_sheet(photograph.colour, found.meshes, tuna, found.mask)
    column = sheet[: int(sheet_layout.BODY.top * sheet_layout.SIZE[1]), 512, :3].mean(axis=1)
    back, flank = column[410:440].mean(), column[200:300].mean()
    assert back < 60.0 < 2.0 * back + 60.0 < flank


def test_no_fish_is_a_one_line_error(clownfish_photo):
    plan = load_species("clownfish").surface
    photograph = clownfish_photo.photograph
    blank = photograph._replace(colour=np.full_like(photograph.colour, 128))
    with pytest.raises(UserError, match="no fish of this shape"):
        find_fish(blank, plan)
    clear = np.zeros(photograph.colour.shape[:2], np.uint8)
    with pytest.raises(UserError, match="no fish of this shape"):
        find_fish(photograph._replace(opacity=clear), plan)


def test_the_fish_is_segmented_under_meshes(clownfish_photo, found_clownfish):
    photograph, truth, _ = clownfish_photo
    meshes = copy_meshes(found_clownfish.meshes)
    mask = segment_under(photograph, meshes)
    assert (mask & truth).sum() > 0.95 * (mask | truth).sum()
    # Background under meshes that are too large is not taken for the fish.
    transform(meshes, 1.35 * np.eye(2), meshes.body.nodes.reshape(-1, 2).mean(axis=0), 0.0)
    wrong = segment_under(photograph, meshes) & ~truth
    assert wrong.sum() < 0.03 * truth.sum()


def test_the_outline_error_is_a_distance():
    plan = load_species("clownfish").surface
    meshes = make_fish_meshes(plan, centred_matrix(800, 600, plan))
    mask = mesh_mask(meshes, (600, 800))
    assert outline_error(meshes, mask) < 1e-6
    for one in meshes.parts.values():
        one.nodes[:] += (0.0, 8.0)
    length = np.ptp(mesh_outlines(meshes)[0][:, 0])
    # Up and down the whole way, along the flanks less.
    assert 0.5 * 8 / length < outline_error(meshes, mask) < 8 / length


@pytest.mark.parametrize("name", ["dorsal", "ventral"])
def test_a_body_that_climbed_into_a_fin_has_a_fin_error(
    accuracy, clownfish_photo, found_clownfish, climb, name
):
    case, plan = accuracy.Case("clownfish"), load_species("clownfish").surface
    meshes = copy_meshes(found_clownfish.meshes)
    assert max(fin_errors(meshes, plan).values()) < 0.005
    assert accuracy.border_error(meshes, case, clownfish_photo.body) < 0.01
    climb(meshes, name, 0.5)
    assert outline_error(meshes, found_clownfish.mask) < 0.005  # the silhouette is the same
    errors = fin_errors(meshes, plan)
    assert max(errors, key=errors.get) == name and errors[name] > GOOD
    true = accuracy.border_error(meshes, case, clownfish_photo.body)
    assert errors[name] == pytest.approx(true, abs=0.012)


@pytest.mark.parametrize("turn", [0.0, 0.6])
def test_the_fin_error_is_a_distance_and_zero_for_the_species_itself(turn):
    for name in ("clownfish", "blacktip_reef_shark"):
        plan = load_species(name).surface
        meshes = make_fish_meshes(plan, centred_matrix(800, 600, plan))
        matrix = 0.7 * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        transform(meshes, matrix, np.zeros(2), np.zeros(2))
        assert fin_errors(meshes, plan) == pytest.approx({"dorsal": 0.0, "ventral": 0.0}, abs=1e-9)
        shows, fin = side_view(plan).fins["dorsal"].shows, meshes.fins["dorsal"]
        way = 0.1 * (fin.mesh.nodes[0] - fin.root_weights @ meshes.body.nodes[-1])
        fin.mesh.nodes[0] += way
        expected = np.hypot(*way[shows].T).mean() / meshes.length
        assert fin_errors(meshes, plan)["dorsal"] == pytest.approx(expected)


@pytest.mark.parametrize("right", [False, True])
def test_the_eye_decides_the_heading(right):
    # A fish without a tail, symmetric fore and aft.
    y, x = np.mgrid[:200, :320]
    shape = np.hypot((x - 160) / 110, (y - 100) / 42) < 1
    colour = np.full((200, 320, 3), (210, 120, 40), np.uint8)
    plan = load_species("clownfish").surface
    matrix, _ = align_shape(plan, shape, right)
    eye = np.round(to_picture(matrix, np.array([plan.eye.at, plan.eye.height]))).astype(int)
    cv2.circle(colour, eye.tolist(), 4, (5, 5, 5), -1, cv2.LINE_AA)
    photograph = Photograph(Path("fish.png"), colour, np.where(shape, 255, 0).astype(np.uint8))
    for flip in (False, True):
        nodes = find_fish(photograph, plan, flip).meshes.body.nodes
        assert (nodes[4, 0, 0] > nodes[4, -1, 0]) == (right ^ flip)


@pytest.mark.nightly
def test_the_meshes_follow_the_eye(accuracy):
    case = accuracy.Case("clownfish", length=420.0, size=(600, 420), other=0.0)
    photograph, truth, _ = accuracy.made(case)
    species = load_species("clownfish")
    # A species that has its eye elsewhere.
    eye = structs.replace(species.surface.eye, at=0.14, height=0.035)
    other = structs.replace(species, surface=structs.replace(species.surface, eye=eye))
    one = find_fish(photograph, other.surface)
    assert outline_error(one.meshes, truth) < 0.01
    body = sheet_layout.crop(
        lift_sheet(photograph.colour, one.meshes, other, one.mask).transpose(2, 0, 1),
        sheet_layout.BODY,
    )
    front, rear = sheet_layout.borders(other.surface)
    top = sheet_layout.half_height(other.surface)
    column = int((eye.at - front) / (rear - front) * body.shape[2])
    row = int((eye.height + top) / (2 * top) * body.shape[1])
    assert body[:3, row, column].max() < 90  # the pupil, in an orange face
    assert body[0, row, column + 40] > 150
