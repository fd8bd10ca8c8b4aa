"""`subsea skin` in a real window: from a photograph to a textured fish, by the mouse."""

import subprocess
import sys
import time
from contextlib import closing

import cv2
import numpy as np
import pytest
from PIL import Image

from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.fish import paint, sheet_layout
from subsea.fish.color_sheet import sheet_of
from subsea.fish.species import load_species, own_species, species_file
from subsea.rendering.fish import preview
from subsea.studio import mesh_edit as edits
from subsea.studio.deformable_mesh import BODY, DORSAL, VENTRAL, attach_fins, copy_meshes
from subsea.studio.lift import rasterize
from subsea.studio.mesh_edit import MeshNode
from subsea.studio.photograph import read_photograph
from subsea.studio.side_view import (
    centred_matrix,
    make_fish_meshes,
    mesh_outlines,
    side_view,
    subdivide,
    to_picture,
)
from subsea.studio.skin_editor.window import SkinEditor
from subsea.studio.tool_window import ToolWindow
from tests.support.scenes import BARE

SIZE = 800, 600
PICTURE = 520, 380  # width and height of the photograph
LENGTH, TILT = 330.0, 0.2
WATER = 60, 120, 130
NAME = "emperor_angelfish"
BELLY = MeshNode(BODY, 8, 8)


def photographed(path):
    """A rendered fish of known outline: an angelfish in other colours, heading right."""
    species = load_species(NAME)
    plan, sheet = species.surface, paint.paint(species)
    sheet = sheet[..., [0, 2, 1]]  # magenta for yellow
    cos, sin = LENGTH * np.cos(TILT), LENGTH * np.sin(TILT)
    turn = np.array([[-cos, sin], [-sin, -cos]])  # heading right, nose down
    matrix = np.column_stack([turn, np.array(PICTURE) / 2 - turn @ (0.5, 0.0)])
    picture = np.full((*PICTURE[::-1], 3), WATER, np.uint8)
    meshes = make_fish_meshes(plan, matrix)
    for ring in mesh_outlines(meshes)[1:]:
        cv2.fillPoly(
            picture, [np.round(16 * ring).astype(np.int32)], (190, 70, 160), cv2.LINE_AA, 4
        )
    fine = subdivide(side_view(plan).body, 8)
    (front, rear), top = sheet_layout.borders(plan), sheet_layout.half_height(plan)
    size = np.array([sheet.shape[1] / (rear - front), 0.8 * sheet.shape[0] / (2.0 * top)])
    texels = rasterize(to_picture(matrix, fine), (fine - (front, -top)) * size - 0.5, PICTURE[::-1])
    there = np.isfinite(texels[..., 0])
    x, y = np.round(texels[there]).astype(int).T
    picture[there] = sheet[y, x]
    cut_out = (picture != WATER).any(axis=2) * np.uint8(255)  # so it is found quickly
    Image.fromarray(np.dstack([picture, cut_out])).save(path)
    return meshes


def test_without_a_display_one_line_says_what_works(monkeypatch, capsys, tmp_path):
    # Must be the first test of this module: the window library has one display at a time.
    for key in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(key, raising=False)
    photo = tmp_path / "angel.png"
    photographed(photo)
    for arguments, what in (
        ([], "no display"),
        (["--out", "sheet.jpg"], "ends in .png"),
        (["--species", "nobody"], "unknown species"),
        (["--mesh", str(photo)], "no meshes of this species"),
        (["--mesh", str(photo), "--flip"], "not both"),
        (["--out", str(photo)], "is the photograph"),
    ):
        assert main(["skin", str(photo), *arguments]) == (2 if arguments else 75)
        said = capsys.readouterr().err
        assert what in said and said.count("\n") == 1
        assert "--auto" in said or arguments


@pytest.fixture(scope="module")
def opened(display, tmp_path_factory):
    """The window on a photograph, and the true outline."""
    path = tmp_path_factory.mktemp("photographs") / "angel.png"
    truth = photographed(path)
    mesh = path.with_name("mesh.json")
    make = lambda window: SkinEditor(window, read_photograph(path), NAME, mesh=mesh)  # noqa: E731
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_DATA_HOME", str(tmp_path_factory.mktemp("home")))
        patch.setattr(preview, "SAMPLES", 0)  # a preview with smooth edges takes twice as long
        with closing(ToolWindow("skin", make, SIZE)) as window:
            yield window, truth


@pytest.fixture
def scene(opened, spots):
    """The window with all edits undone, and the true outline."""
    window, truth = opened
    rest(window)
    editor = window.tool
    while editor.history.may_undo:
        editor.undo()
    editor.canvas.mode = "pull"
    window.frame(0.1)
    rest(window)
    window.frame(0.1)
    return window, truth


def rest(window):
    """Run frames, few lest those take its time, until all background work is done."""
    end = time.monotonic() + 120.0
    while window.busy or window.tool.working:
        assert time.monotonic() < end, window.doing
        window.frame(0.1)
        time.sleep(0.1)


def at(window, place):
    left, top = window.window.position
    x, y = window.tool.canvas.view.on_screen(place)
    return round(left + float(x)), round(top + float(y))


def shown(window):
    """The pixels of the window."""
    return window.window_set.picture().astype(int)


def drag(window, user, begin, end):
    user.drag(window, begin, end, hold_s=0.5)


def laid_across(document):
    height, width = document.photograph.colour.shape[:2]
    plan = document.species.surface
    return document.from_photo(make_fish_meshes(plan, centred_matrix(width, height, plan)))


def off(meshes, truth):
    """Mean distance between the nodes on outlines of two nets, body lengths."""
    border = edits.border_nodes(meshes, (BODY,))
    far = edits.node_places(meshes, border) - edits.node_places(truth, border)
    return float(np.hypot(*far.T).mean()) / LENGTH


def test_the_fish_is_found_and_wears_the_photograph(scene):
    window, truth = scene
    editor, document = window.tool, window.tool.document
    assert off(document.to_photo(document.meshes), truth) < 0.03
    assert document.error < 0.015
    assert not editor.history.unsaved  # no manual edit yet
    flank = np.s_[180:330, 400:700]
    painted = paint.paint(load_species(NAME))[flank][..., :3].mean(axis=(0, 1))
    worn = document.sheet[flank][..., :3].mean(axis=(0, 1))
    assert worn[[0, 2, 1]] == pytest.approx(painted, abs=15.0)
    assert np.abs(worn - painted).max() > 50.0
    picture = shown(window)
    magenta = (picture[..., 0] > picture[..., 1] + 60) & (picture[..., 2] > picture[..., 1] + 60)
    assert magenta[:, :500].sum() > 5000  # the photograph
    assert magenta[:, 560:].sum() > 1000  # the textured fish, and the sheet


def test_a_back_inside_the_dorsal_fin_is_in_the_score_of_the_fins(scene):
    window, _ = scene
    document = window.tool.document
    assert max(document.fin_errors.values()) < 0.01
    document.meshes = copy_meshes(document.meshes)
    root, edge = document.meshes.parts[DORSAL].nodes
    document.meshes.body.nodes[0, 6:13] += 0.5 * (edge - root)[3:10]
    attach_fins(document.meshes)
    document.record()
    rest(window)
    assert document.error < 0.015  # the silhouette is the same
    assert document.fin_errors["dorsal"] > 0.015


def test_a_node_is_dragged_and_the_mesh_follows(scene, user, spots):
    window, _ = scene
    editor, document = window.tool, window.tool.document
    before = document.meshes
    place = edits.node_places(before, [BELLY])[0]
    start = {name: one.nodes.copy() for name, one in before.parts.items()}
    to = at(window, place + (0.0, 25.0))
    drag(window, user, at(window, place), to)
    rest(window)
    moved = {name: one.nodes - start[name] for name, one in document.meshes.parts.items()}
    assert moved[BODY][8, 8, 1] > 15.0
    assert moved[BODY][8, 8, 1] > moved[BODY][8, 7, 1] > 1.0
    assert np.abs(moved[BODY][0]).max() < 1e-6  # the back is far away
    assert editor.history.unsaved
    user.do("key", "ctrl+z")
    user.until(window, lambda: np.array_equal(document.meshes.body.nodes, start[BODY]))
    user.do("key", "ctrl+y")
    user.until(window, lambda: document.meshes.body.nodes[8, 8, 1] > start[BODY][8, 8, 1] + 15.0)


@pytest.mark.nightly
def test_a_shift_click_sets_an_anchor_and_lifts_it(scene, user, spots):
    window, _ = scene
    document = window.tool.document
    node = MeshNode(VENTRAL, 1, 6)
    place = at(window, edits.node_places(document.meshes, [node])[0])
    for there in ([node], []):
        user.do("keydown", "shift")
        drag(window, user, place, place)
        user.do("keyup", "shift")
        user.until(window, lambda there=there: edits.anchored_nodes(document.meshes) == there)
    spots.click(window, "Anchor")
    user.glide(window, 0.2)
    drag(window, user, place, place)
    user.until(window, lambda: edits.anchored_nodes(document.meshes) == [node])
    spots.click(window, "Lift anchors")
    user.until(window, lambda: not edits.anchored_nodes(document.meshes))


@pytest.mark.nightly
def test_the_whole_is_moved_turned_and_scaled_and_relaxing_mends_it(scene, user, spots):
    window, truth = scene
    document = window.tool.document
    good = document.meshes.body.nodes.copy()
    spots.click(window, "Move, turn, scale")
    user.glide(window, 0.2)
    frame = edits.transform_box(document.meshes)
    drag(window, user, at(window, frame.middle), at(window, frame.middle + (60.0, 0.0)))
    assert document.meshes.body.nodes == pytest.approx(good + (60.0, 0.0), abs=1.0)
    user.do("key", "ctrl+z")
    user.until(window, lambda: np.array_equal(document.meshes.body.nodes, good))
    drag(window, user, at(window, frame.middle), at(window, frame.middle + (4.0, -5.0)))
    shown = edits.transform_box(document.meshes)
    drag(
        window,
        user,
        at(window, shown.corners[0]),
        at(window, shown.corners[0] * 0.99 + shown.corners[2] * 0.01),
    )
    shown = edits.transform_box(document.meshes)
    drag(window, user, at(window, shown.knob), at(window, shown.knob + (3.0, 0.0)))
    rest(window)
    spoilt = document.error
    assert spoilt > 0.008
    assert edits.transform_box(document.meshes).ahead != pytest.approx(frame.ahead, abs=0.005)
    spots.click(window, "Relax###relax")
    user.until(window, lambda: document.relaxing)
    user.until(window, lambda: not document.relaxing, 60.0)
    rest(window)
    assert document.error < 0.5 * spoilt
    assert off(document.to_photo(document.meshes), truth) < 0.03
    spots.click(window, "Reset")
    rest(window)
    assert document.error > 0.05
    assert document.meshes.body.along == pytest.approx(laid_across(document).body.along)
    user.do("key", "ctrl+z")
    user.until(window, lambda: edits.transform_box(document.meshes).ahead @ frame.ahead > 0.9)
    spots.click(window, "Flip")
    user.until(window, lambda: edits.transform_box(document.meshes).ahead @ frame.ahead < -0.9)
    user.do("key", "ctrl+z")
    user.until(window, lambda: edits.transform_box(document.meshes).ahead @ frame.ahead > 0.9)


@pytest.mark.nightly
def test_while_it_relaxes_a_node_follows_the_pointer_and_goes_back(scene, user, spots):
    window, _ = scene
    editor, document = window.tool, window.tool.document
    before = document.meshes.body.nodes.copy()
    place = edits.node_places(document.meshes, [BELLY])[0]
    user.do("mousemove", *at(window, place))
    user.glide(window, 0.3)
    user.do("mousedown", 1)
    user.until(window, lambda: editor.canvas.dragging)
    document.relax(True)
    user.do("mousemove", *at(window, place + (0.0, 30.0)))
    user.until(window, lambda: document.meshes.body.nodes[8, 8, 1] > place[1] + 8.0)
    assert document.relaxing
    user.do("mouseup", 1)
    user.until(window, lambda: not document.relaxing, 60.0)
    assert np.abs(document.meshes.body.nodes - before).max() < 3.0


def test_sliders_and_edges(scene, user, spots):
    window, _ = scene
    document = window.tool.document
    spots.drag(window, "smoothing", 0.1, 0.9)
    user.until(window, lambda: document.sliders.smoothing > 8.0)
    before = shown(window)
    spots.click(window, "Edges")
    user.until(window, lambda: np.abs(shown(window) - before)[100:500, 50:500].mean() > 20.0)
    spots.click(window, "Photograph")
    spots.click(window, "Usual")
    user.until(window, lambda: document.sliders.smoothing < 2.0)


def test_the_fish_is_turned_by_the_pointer_and_swims(scene, user, spots):
    window, _ = scene
    preview = window.tool.preview
    orbit = preview.orbit
    user.glide(window, 0.2)
    left, top, right, bottom = spots["preview"]
    x, y = window.window.position
    middle = round(x + (left + right) / 2), round(y + (top + bottom) / 2)
    drag(window, user, middle, (middle[0] - 60, middle[1]))
    assert preview.orbit.turn > orbit.turn + 0.3
    crop = np.s_[int(top) : int(bottom), int(left) : int(right)]
    before = shown(window)[crop]
    user.glide(window, 0.3)
    assert np.abs(shown(window)[crop] - before).max() > 60
    spots.click(window, "Swims")
    user.until(window, lambda: not window.tool.swims)
    before = shown(window)[crop]
    user.glide(window, 0.3)
    assert np.array_equal(shown(window)[crop], before)


def test_a_mesh_is_saved_and_loaded(scene, user, spots):
    window, _ = scene
    editor, document = window.tool, window.tool.document
    kept = document.to_photo(document.meshes)
    spots.click(window, "Keep mesh")
    user.until(window, editor.mesh_file.is_file)
    spots.click(window, "Flip")
    user.until(window, lambda: editor.history.may_undo)
    spots.click(window, "Take up mesh")
    user.until(
        window,
        lambda: np.allclose(
            document.to_photo(document.meshes).body.nodes, kept.body.nodes, atol=0.01
        ),
    )


@pytest.mark.nightly
def test_it_is_saved_as_an_own_species(scene, user, spots):
    window, _ = scene
    editor, document = window.tool, window.tool.document
    foreign = own_species() / "other.png"
    foreign.parent.mkdir(parents=True, exist_ok=True)
    foreign.touch()
    with pytest.raises(UserError, match=r"other\.png: exists; "):
        editor.save_as("other", "Other")
    spots.click(window, "Flip")
    rest(window)
    spots.click(window, "Save")
    user.glide(window, 0.3)
    spots.type(window, "its name", "Moorish jewel")
    spots.click(window, "Save it")
    user.until(window, lambda: not editor.history.unsaved and document.name == "moorish_jewel")
    rest(window)
    species = load_species("moorish_jewel")
    assert species.name == "Moorish jewel" and species_file("moorish_jewel").is_file()
    assert np.array_equal(sheet_of(species), document.sheet)
    assert load_species(NAME).skin.sheet is None  # the shipped one is unchanged
    # From now on it is saved immediately.
    user.do("key", "ctrl+z")
    user.until(window, lambda: editor.history.unsaved)
    rest(window)
    editor.mesh_file.unlink()
    user.do("key", "ctrl+s")
    user.until(window, lambda: not editor.history.unsaved)
    assert editor.mesh_file.is_file()  # --mesh named it
    editor.out = document.photograph.path
    with pytest.raises(UserError, match="is the photograph"):
        editor.save()
    editor.out = None
    assert np.array_equal(sheet_of(load_species("moorish_jewel")), document.sheet)


@pytest.mark.nightly
def test_a_world_shows_a_species_that_was_saved(scene, tmp_path):
    window, _ = scene
    window.tool.save_as("moorish_pearl", "Moorish pearl")
    rest(window)
    # Magenta, unlike all other fishes.
    out = tmp_path / "sea.png"
    name = "moorish_pearl"
    shown = "--scenario", str(BARE), "--set", f"fish.1.species={name}", "--follow", name
    short = "--size", "160x120", "--seconds", "0.05", "--quality", "low"
    command = [sys.executable, "-m", "subsea", "film", str(out), *shown, *short]
    subprocess.run(command, check=True, timeout=250)
    red, green, blue = np.asarray(Image.open(out)).astype(int).transpose(2, 0, 1)
    magenta = (red > green + 60) & (blue > green + 40)
    assert magenta[60:90, 70:90].mean() > 0.08  # the camera follows it
