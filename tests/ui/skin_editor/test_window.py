"""`subsea skin` in a real window: from a photograph to a fish that wears it, by the mouse."""

import subprocess
import sys
from contextlib import closing

import cv2
import numpy as np
import pytest
from PIL import Image

from subsea.cli.main import main
from subsea.core.errors import UserError
from subsea.fish import paint
from subsea.fish.color_sheet import sheet_of
from subsea.fish.photo import mesh_edit as edits
from subsea.fish.photo.deformable_mesh import BODY, VENTRAL, meshes
from subsea.fish.photo.lift import drawn
from subsea.fish.photo.mesh_edit import Node
from subsea.fish.photo.photograph import read
from subsea.fish.photo.side_view import across, at_rest, finer, laid, outlines, placed
from subsea.fish.species import load_species, own_species, species_file
from subsea.ui.skin_editor.window import Dressing
from subsea.ui.tool_window import Bench
from tests.support.scenes import BARE

SIZE = 800, 600
PICTURE = 520, 380  # width and height of the photograph
LENGTH, TILT = 330.0, 0.2
WATER = 60, 120, 130
NAME = "emperor_angelfish"
BELLY = Node(BODY, 8, 8)


def photographed(path):
    """A rendered fish of known outline: an angelfish in other colours, heading right."""
    species = load_species(NAME)
    plan, sheet = species.surface, paint.paint(species)
    sheet = sheet[..., [0, 2, 1]]  # magenta for yellow
    cos, sin = LENGTH * np.cos(TILT), LENGTH * np.sin(TILT)
    turn = np.array([[-cos, sin], [-sin, -cos]])  # it heads right, its nose down
    matrix = np.column_stack([turn, np.array(PICTURE) / 2 - turn @ (0.5, 0.0)])
    picture = np.full((*PICTURE[::-1], 3), WATER, np.uint8)
    net = laid(plan, matrix)
    for ring in outlines(net)[1:]:
        cv2.fillPoly(
            picture, [np.round(16 * ring).astype(np.int32)], (190, 70, 160), cv2.LINE_AA, 4
        )
    fine = finer(at_rest(plan).body, 8)
    (front, rear), top = paint.borders(plan), paint.half_height(plan)
    size = np.array([sheet.shape[1] / (rear - front), 0.8 * sheet.shape[0] / (2.0 * top)])
    texels = drawn(placed(matrix, fine), (fine - (front, -top)) * size - 0.5, PICTURE[::-1])
    there = np.isfinite(texels[..., 0])
    x, y = np.round(texels[there]).astype(int).T
    picture[there] = sheet[y, x]
    cut_out = (picture != WATER).any(axis=2) * np.uint8(255)  # so it is found quickly
    Image.fromarray(np.dstack([picture, cut_out])).save(path)
    return net


def test_without_a_display_one_line_says_what_works(monkeypatch, capsys, tmp_path):
    # The first of this module: the window library knows one display at a time.
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
        assert main(["skin", str(photo), *arguments]) == 2
        said = capsys.readouterr().err
        assert what in said and said.count("\n") == 1
        assert "--auto" in said or arguments


@pytest.fixture(scope="module")
def scene(display, tmp_path_factory):
    """The window over a photograph, and the truth about that."""
    home = tmp_path_factory.mktemp("home")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_DATA_HOME", str(home))
        yield from opened(tmp_path_factory)


def opened(tmp_path_factory):
    path = tmp_path_factory.mktemp("photographs") / "angel.png"
    truth = photographed(path)
    mesh = path.with_name("mesh.json")
    dressing = lambda bench: Dressing(bench, read(path), NAME, mesh=mesh)  # noqa: E731
    with closing(Bench("skin", dressing, SIZE)) as bench:
        rest(bench)
        yield bench, truth


def rest(bench):
    """Frames until nothing is done in the background any more."""
    from tests.support.windows import Hands

    Hands.until(bench, lambda: not (bench.busy or bench.craft.working), 120.0)


def at(bench, place):
    left, top = bench.window.position
    x, y = bench.craft.easel.canvas.on_screen(place)
    return round(left + float(x)), round(top + float(y))


def drag(bench, hands, begin, end, key=None):
    hands.do("mousemove", *begin)
    hands.glide(bench, 0.3)
    if key:
        hands.do("keydown", key)
        hands.glide(bench, 0.2)
    hands.do("mousedown", 1)
    hands.glide(bench, 0.2)
    hands.do("mousemove", *end)
    hands.glide(bench, 1.0)
    hands.do("mouseup", 1)
    hands.glide(bench, 0.3)
    if key:
        hands.do("keyup", key)
        hands.glide(bench, 0.2)


def laid_across(table):
    height, width = table.photograph.colour.shape[:2]
    plan = table.species.surface
    return table.small(laid(plan, across(width, height, plan)))


def off(net, truth):
    """Mean distance between the nodes on outlines of two nets, body lengths."""
    border = edits.border(net, (BODY,))
    far = edits.places(net, border) - edits.places(truth, border)
    return float(np.hypot(*far.T).mean()) / LENGTH


def test_the_fish_is_found_and_wears_the_photograph(scene):
    bench, truth = scene
    table = bench.craft
    assert off(table.large(table.net), truth) < 0.03
    assert table.error < 0.015
    assert not table.unsaved  # nothing was done by hand
    flank = np.s_[180:330, 400:700]
    painted = paint.paint(load_species(NAME))[flank][..., :3].mean(axis=(0, 1))
    worn = table.sheet[flank][..., :3].mean(axis=(0, 1))
    assert worn[[0, 2, 1]] == pytest.approx(painted, abs=15.0)
    assert np.abs(worn - painted).max() > 50.0
    shown = bench.picture().astype(int)
    magenta = (shown[..., 0] > shown[..., 1] + 60) & (shown[..., 2] > shown[..., 1] + 60)
    assert magenta[:, :500].sum() > 5000  # the photograph
    assert magenta[:, 560:].sum() > 1000  # the fish that wears it, and the sheet


def test_a_node_is_dragged_and_the_mesh_follows(scene, hands, spots):
    bench, _ = scene
    table = bench.craft
    before = table.net
    place = edits.places(before, [BELLY])[0]
    start = {name: one.nodes.copy() for name, one in meshes(before).items()}
    to = at(bench, place + (0.0, 25.0))
    drag(bench, hands, at(bench, place), to)
    rest(bench)
    moved = {name: one.nodes - start[name] for name, one in meshes(table.net).items()}
    assert moved[BODY][8, 8, 1] > 15.0
    assert moved[BODY][8, 8, 1] > moved[BODY][8, 7, 1] > 1.0
    assert np.abs(moved[BODY][0]).max() < 1e-6  # the back is far away
    assert table.unsaved
    hands.do("key", "ctrl+z")
    hands.until(bench, lambda: np.array_equal(table.net.body.nodes, start[BODY]))
    hands.do("key", "ctrl+y")
    hands.until(bench, lambda: table.net.body.nodes[8, 8, 1] > start[BODY][8, 8, 1] + 15.0)


def test_a_shift_click_sets_an_anchor_and_lifts_it(scene, hands, spots):
    bench, _ = scene
    table = bench.craft
    node = Node(VENTRAL, 1, 6)
    place = at(bench, edits.places(table.net, [node])[0])
    for there in ([node], []):
        drag(bench, hands, place, place, "shift")
        hands.until(bench, lambda there=there: edits.anchors(table.net) == there)
    spots.click(bench, "Anchor")
    hands.glide(bench, 0.2)
    drag(bench, hands, place, place)
    hands.until(bench, lambda: edits.anchors(table.net) == [node])
    spots.click(bench, "Lift anchors")
    hands.until(bench, lambda: not edits.anchors(table.net))
    rest(bench)


def test_the_whole_is_moved_turned_and_scaled_and_relaxing_mends_it(scene, hands, spots):
    bench, truth = scene
    table = bench.craft
    while table.may_undo:
        table.undo()
    hands.glide(bench, 0.2)
    good = table.net.body.nodes.copy()
    spots.click(bench, "Move, turn, scale")
    hands.glide(bench, 0.2)
    frame = edits.frame(table.net)
    drag(bench, hands, at(bench, frame.middle), at(bench, frame.middle + (60.0, 0.0)))
    assert table.net.body.nodes == pytest.approx(good + (60.0, 0.0), abs=1.0)
    hands.do("key", "ctrl+z")
    hands.until(bench, lambda: np.array_equal(table.net.body.nodes, good))
    drag(bench, hands, at(bench, frame.middle), at(bench, frame.middle + (4.0, -5.0)))
    shown = edits.frame(table.net)
    drag(
        bench,
        hands,
        at(bench, shown.corners[0]),
        at(bench, shown.corners[0] * 0.99 + shown.corners[2] * 0.01),
    )
    shown = edits.frame(table.net)
    drag(bench, hands, at(bench, shown.knob), at(bench, shown.knob + (3.0, 0.0)))
    rest(bench)
    spoilt = table.error
    assert spoilt > 0.008
    assert edits.frame(table.net).ahead != pytest.approx(frame.ahead, abs=0.005)
    spots.click(bench, "Relax###relax")
    hands.until(bench, lambda: table.relaxing)
    hands.until(bench, lambda: not table.relaxing, 60.0)
    rest(bench)
    assert table.error < 0.5 * spoilt
    assert off(table.large(table.net), truth) < 0.03
    spots.click(bench, "Anew")
    hands.until(bench, lambda: table.error > 0.05)
    assert table.net.body.along == pytest.approx(laid_across(table).body.along)
    hands.do("key", "ctrl+z")
    hands.until(bench, lambda: edits.frame(table.net).ahead @ frame.ahead > 0.9)
    spots.click(bench, "Flip")
    hands.until(bench, lambda: edits.frame(table.net).ahead @ frame.ahead < -0.9)
    hands.do("key", "ctrl+z")
    hands.until(bench, lambda: edits.frame(table.net).ahead @ frame.ahead > 0.9)
    rest(bench)


def test_while_it_relaxes_a_node_follows_the_hand_and_goes_back(scene, hands, spots):
    bench, _ = scene
    table = bench.craft
    hands.glide(bench, 0.2)
    spots.click(bench, "Pull")
    rest(bench)
    before = table.net.body.nodes.copy()
    place = edits.places(table.net, [BELLY])[0]
    hands.do("mousemove", *at(bench, place))
    hands.glide(bench, 0.3)
    hands.do("mousedown", 1)
    hands.until(bench, lambda: table.easel.dragging)
    table.relax(True)
    hands.do("mousemove", *at(bench, place + (0.0, 30.0)))
    hands.until(bench, lambda: table.net.body.nodes[8, 8, 1] > place[1] + 8.0)
    assert table.relaxing
    hands.do("mouseup", 1)
    hands.until(bench, lambda: not table.relaxing, 60.0)
    assert np.abs(table.net.body.nodes - before).max() < 3.0
    rest(bench)


def test_sliders_and_edges(scene, hands, spots):
    bench, _ = scene
    table = bench.craft
    hands.glide(bench, 0.2)
    spots.drag(bench, "smoothing", 0.1, 0.9)
    hands.until(bench, lambda: table.sliders.smoothing > 8.0)
    before = bench.picture().astype(int)
    spots.click(bench, "Edges")
    hands.until(bench, lambda: np.abs(bench.picture() - before)[100:500, 50:500].mean() > 20.0)
    spots.click(bench, "Photograph")
    spots.click(bench, "Usual")
    hands.until(bench, lambda: table.sliders.smoothing < 2.0)


def test_the_fish_turns_under_the_hand_and_swims(scene, hands, spots):
    bench, _ = scene
    preview = bench.craft.preview
    orbit = preview.orbit
    hands.glide(bench, 0.2)
    left, top, right, bottom = spots["preview"]
    x, y = bench.window.position
    middle = round(x + (left + right) / 2), round(y + (top + bottom) / 2)
    drag(bench, hands, middle, (middle[0] - 60, middle[1]))
    assert preview.orbit.turn > orbit.turn + 0.3
    crop = np.s_[int(top) : int(bottom), int(left) : int(right)]
    before = bench.picture()[crop].astype(int)
    hands.glide(bench, 0.3)
    assert np.abs(bench.picture()[crop] - before).max() > 60
    spots.click(bench, "Swims")
    hands.until(bench, lambda: not preview.swims)
    before = bench.picture()[crop].astype(int)
    hands.glide(bench, 0.3)
    assert np.array_equal(bench.picture()[crop], before)


def test_a_mesh_is_kept_and_taken_up_again(scene, hands, spots):
    bench, _ = scene
    table = bench.craft
    hands.glide(bench, 0.2)
    kept = table.large(table.net)
    spots.click(bench, "Keep mesh")
    hands.until(bench, table.mesh_file.is_file)
    spots.click(bench, "Flip")
    hands.until(bench, lambda: table.may_undo)
    spots.click(bench, "Take up mesh")
    same = lambda: np.allclose(table.large(table.net).body.nodes, kept.body.nodes, atol=0.01)  # noqa: E731
    hands.until(bench, same)
    rest(bench)


def test_saved_under_a_name_of_its_own_a_world_shows_it(scene, hands, spots, tmp_path):
    bench, _ = scene
    table = bench.craft
    hands.glide(bench, 0.2)
    foreign = own_species() / "other.png"
    foreign.parent.mkdir(parents=True, exist_ok=True)
    foreign.touch()
    with pytest.raises(UserError, match=r"other\.png: is there already"):
        table._save_as("other", "Other")
    spots.click(bench, "Save")
    hands.glide(bench, 0.3)
    spots.type(bench, "its name", "Moorish jewel")
    spots.click(bench, "Save it")
    hands.until(bench, lambda: not table.unsaved and table.name == "moorish_jewel")
    rest(bench)
    species = load_species("moorish_jewel")
    assert species.name == "Moorish jewel" and species_file("moorish_jewel").is_file()
    assert np.array_equal(sheet_of(species), table.sheet)
    assert load_species(NAME).skin.sheet is None  # the shipped one is as it was
    # From now on it is saved at once.
    hands.do("key", "ctrl+z")
    hands.until(bench, lambda: table.unsaved)
    rest(bench)
    table.mesh_file.unlink()
    hands.do("key", "ctrl+s")
    hands.until(bench, lambda: not table.unsaved)
    assert table.mesh_file.is_file()  # --mesh named it
    table._out = table.photograph.path
    with pytest.raises(UserError, match="is the photograph"):
        table.save()
    table._out = None
    assert np.array_equal(sheet_of(load_species("moorish_jewel")), table.sheet)
    # Magenta, as no other fish is.
    out = tmp_path / "sea.png"
    name = "moorish_jewel"
    shown = "--scenario", str(BARE), "--set", f"fish.1.species={name}", "--follow", name
    short = "--size", "160x120", "--seconds", "0.05", "--quality", "low"
    command = [sys.executable, "-m", "subsea", "film", str(out), *shown, *short]
    subprocess.run(command, check=True, timeout=250)
    red, green, blue = np.asarray(Image.open(out)).astype(int).transpose(2, 0, 1)
    magenta = (red > green + 60) & (blue > green + 40)
    assert magenta[60:90, 70:90].mean() > 0.08  # the camera follows it
