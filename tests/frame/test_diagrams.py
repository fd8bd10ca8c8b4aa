"""Diagrams, compared with closed forms and with bodies and perception."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.biomechanics.body import UNITS
from subsea.dive.start import start_world
from subsea.frame.diagrams import (
    DIAGRAMS,
    FAINT,
    MOST,
    STRONG,
    DiagramBuilder,
    Label,
    chosen_diagrams,
    frustum_edges,
    place_labels,
    projected,
    sensitivity_box,
)
from subsea.geometry.rotation import matrix
from subsea.motor.pose import control_points_world, nodes_world
from subsea.perception.collision import sensitivity, share_inside
from subsea.perception.vision import FIELD_COS, ahead_of, eye_of, in_view
from subsea.state import NOBODY
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import DISPLAYS, cockpit, display_rig, views_for
from subsea.view.rig import pose_from_angles, views
from subsea.world.step import step

SIZE = (320, 180)


@pytest.fixture(scope="module")
def world():
    world = start_world("peaceful")
    for _ in range(40):
        step(world, NEUTRAL)
    return world


@pytest.fixture
def diagram(world):
    """name, chosen → the drawing of one diagram from the cockpit."""

    def draw(name, chosen=None, seen=None):
        return DiagramBuilder(world).draw([name], seen or sights(world), 1.0, chosen)

    return draw


def sights(world):
    return views_for("mono", SIZE, cockpit(world.state.submarine, 1.0))


def from_afar(world):
    """All fishes are in sight."""
    return views_for(
        "mono", SIZE, pose_from_angles(np.array([0.0, -3000.0, -200.0]), np.pi / 2, 0.0)
    )


@pytest.fixture(scope="module")
def in_sight(world):
    labels = DiagramBuilder(world).draw(["indices"], sights(world), 1.0).labels
    seen = [int(label.text) for label in labels]
    assert 5 < len(seen) < len(world.state.fishes.species)
    return seen


def test_springs_end_in_the_nodes_of_the_fish_that_looks_largest(world, diagram, in_sight):
    lines = diagram("scaffold").lines
    assert len(lines.ends) == len(UNITS) * min(len(in_sight), MOST["scaffold"])
    for k, i in enumerate(in_sight[:3]):
        nodes = nodes_world(world.state.fishes, world.library, i)
        own = lines.ends[k * len(UNITS) : (k + 1) * len(UNITS)]
        assert own == pytest.approx(nodes[UNITS], abs=2e-3)
    assert (lines.lift > 0.0).all()


def test_contracted_muscles_are_red_and_all_else_keeps_its_colour(world, diagram):
    lines = diagram("scaffold").lines
    colours = lines.colours.reshape(-1, len(UNITS), 4)
    long = np.linalg.norm(lines.ends[:, 1] - lines.ends[:, 0], axis=1).reshape(-1, len(UNITS))
    left, right = long[:, 0], long[:, 1]  # the first muscles of both sides of a body
    unlike = np.abs(left - right) > 0.03 * left
    assert unlike.any()
    green = colours[..., 1]
    redder = green[:, 0] < green[:, 1]
    assert (redder == (left < right))[unlike].all()
    assert np.ptp(colours[:, 12:54, :3], axis=0).max() == 0.0


def test_the_control_mesh_joins_neighbours_of_the_skin(world, diagram, in_sight):
    lines = diagram("control mesh").lines
    a_fish = 2 * (9 * 20 + 8 * 21) + 2 * (2 * 11 + 12)
    assert len(lines.ends) == a_fish * min(len(in_sight), MOST["control mesh"])
    points = control_points_world(world.state.fishes, world.library, in_sight[0])
    ends = lines.ends[:a_fish].reshape(-1, 3)
    gaps = np.linalg.norm(ends[:, None] - points[None], axis=2)
    assert gaps.min(axis=1).max() < 2e-3
    assert len(np.unique(gaps.argmin(axis=1))) > 350  # most lie apart from each other


def test_the_sensitivity_box_agrees_with_perception(world):
    bodies = world.state.fishes
    rng = np.random.default_rng(3)
    i, j = 7, 30
    low, high = sensitivity_box(world, i)
    rows = [part for part in bodies if len(part) == len(bodies.position)]
    kept = [part[[i, j]].copy() for part in rows]
    try:
        turn = matrix(bodies.orientation[i].astype(float))
        bodies.velocity[j] = bodies.velocity[i]  # nobody approaches
        bodies.length[j], bodies.snout[j], bodies.girth[j] = 0.02, 0.01, 0.0  # nearly a point
        found = []
        for _ in range(800):
            p = (low + high) / 2 + rng.uniform(-0.6, 0.6, 3) * (high - low)
            if np.abs(p - low).min() < 0.05 or np.abs(p - high).min() < 0.05:
                continue
            ray = p - (bodies.snout[i], 0.0, 0.0)
            if ray[0] < FIELD_COS * np.linalg.norm(ray):
                continue  # straight behind it is blind
            bodies.position[j] = bodies.position[i] + turn @ p
            margin = sensitivity(world.state.minds, i, world.nature)[0]
            inside = share_inside(bodies, i, j, margin, 0.1) > 0.0
            assert inside == ((low < p) & (p < high)).all()
            found.append(inside)
        assert 20 < sum(found) < len(found) - 20
    finally:
        for part, old in zip(rows, kept, strict=True):
            part[[i, j]] = old


def test_boxes_of_threatened_fishes_are_red(world, diagram, in_sight):
    minds = world.state.minds
    i, j = in_sight[:2]
    before = minds.threat[[i, j]].copy()
    try:
        minds.threat[[i, j]] = NOBODY
        calm = diagram("sensitivity").lines
        minds.threat[i] = j
        alarmed = diagram("sensitivity").lines
    finally:
        minds.threat[[i, j]] = before
    assert len(alarmed.ends) == len(calm.ends) + 1
    assert (alarmed.colours[:12, 0] > 0.9).all()
    assert (calm.colours[:12, 0] < 0.5).all()
    assert alarmed.ends[13, 1] == pytest.approx(world.state.fishes.position[j], abs=1e-3)


def test_bonds_of_a_school_go_to_leaders_and_companions(world, diagram):
    minds, fishes = world.state.minds, world.state.fishes
    lines = diagram("school").lines
    assert len(lines.ends) > 10
    place = fishes.position
    pairs = set()
    for a, b in lines.ends:
        ends = [int(np.linalg.norm(place - end, axis=1).argmin()) for end in (a, b)]
        assert np.linalg.norm(place[ends] - (a, b), axis=1).max() < 1e-3
        pairs.add(tuple(ends))
    for one, other in pairs:
        bonds = {*minds.neighbour[one], *minds.neighbour[other], minds.leader[one]}
        assert {one, other} & bonds


def test_the_view_volume_is_where_a_fish_sees(world, diagram, in_sight):
    i = in_sight[0]
    lines = diagram("perception", i).lines
    bodies, nature = world.state.fishes, world.nature
    eye, ahead = np.array(eye_of(bodies, i)), ahead_of(bodies, i)
    points = lines.ends.reshape(-1, 3).astype(float)
    far = np.linalg.norm(points - eye, axis=1)
    seen = np.isclose(far, nature.vision_cm, rtol=1e-3)
    smelled = np.isclose(far, nature.smell_cm, rtol=1e-3)
    assert seen.sum() > 100
    assert smelled.sum() > 100
    assert (seen | smelled | (far < 0.1)).all()
    cosines = (points[seen] - eye) @ ahead / far[seen]
    assert cosines.min() == pytest.approx(np.cos(np.radians(150.0)), abs=1e-3)
    for p in points[seen][::7]:
        inner = eye + 0.99 * (p - eye) + 0.01 * np.array(ahead)
        outer = eye + 1.01 * (p - eye)
        assert in_view(tuple(eye), ahead, tuple(inner), nature.vision_cm)
        assert not in_view(tuple(eye), ahead, tuple(outer), nature.vision_cm)


def test_a_frustum_ends_in_the_corners_of_its_picture(world):
    [view] = sights(world)
    edges = frustum_edges(view, 200.0)
    both = view.projection.astype(float) @ view.view.astype(float)
    clip = np.concatenate([edges[:4, 1], np.ones((4, 1))], axis=1) @ both.T
    assert np.abs(clip[:, :2] / clip[:, 3:]) == pytest.approx(np.ones((4, 2)), abs=1e-4)
    assert clip[:, 3] == pytest.approx(np.full(4, 200.0), abs=1e-2)  # along the axis
    assert (edges[:4, 0] == view.eye).all()


def test_frusta_are_those_of_others_than_the_onlooker(world, diagram, in_sight):
    assert len(diagram("frusta").lines.ends) == 0
    assert len(diagram("frusta", seen=from_afar(world)).lines.ends) == 8
    assert len(diagram("frusta", in_sight[0]).lines.ends) == 2 * 8


def test_axes_are_those_of_the_body_and_right_handed(world, diagram, in_sight):
    lines = diagram("axes").lines
    n = (len(lines.ends) - 3) // 3
    ways = (lines.ends[:, 1] - lines.ends[:, 0])[:-3].reshape(3, n, 3)
    i = in_sight[0]
    axes = matrix(world.state.fishes.orientation[i].astype(float))
    unit = ways[:, 0] / np.linalg.norm(ways[:, 0], axis=1)[:, None]
    assert np.abs(unit.T - axes).max() < 1e-4
    assert np.linalg.det(unit) == pytest.approx(1.0, abs=1e-4)


def test_bounds_lie_on_the_cylinder(world, diagram):
    ends = diagram("bounds").lines.ends.reshape(-1, 3).astype(float)
    assert np.hypot(*ends[:, :2].T) == pytest.approx(
        np.full(len(ends), world.scenario.bounds.radius_cm), rel=1e-5
    )
    assert ends[:, 2].max() == 0.0
    assert ends[:, 2].min() < -0.5 * world.scenario.bounds.depth_cm


def test_paths_follow_past_positions_and_forget_ticks_taken_back():
    world = start_world("mating")
    builder, places = DiagramBuilder(world), []
    for _ in range(30):
        step(world, NEUTRAL)
        builder.follow()
        places.append(world.state.fishes.position[0].astype(float))
    seen = views_for("mono", SIZE, pose_from_angles(places[-1] - (0, 150, 0), np.pi / 2, 0.0))
    ends = builder.draw(["paths"], seen, 1.0, chosen=0).lines
    own = ends.ends[ends.colours[:, 3] == STRONG]
    assert len(own) >= 9
    assert own[-1, 1] == pytest.approx(places[-1], abs=1e-3)
    for point in own[:, 0]:
        assert np.linalg.norm(np.array(places) - point, axis=1).min() < 1e-3
    world.state.tick -= 15
    after = builder.draw(["paths"], seen, 1.0, chosen=0).lines
    assert (after.colours[:, 3] == STRONG).sum() < len(own)


def test_the_chosen_fish_stands_out(world, diagram, in_sight):
    i = in_sight[4]
    lines = diagram("scaffold", i).lines
    strong = lines.colours[:, 3] == np.float32(STRONG)
    assert strong.sum() == len(UNITS)
    assert lines.ends[strong] == pytest.approx(
        nodes_world(world.state.fishes, world.library, i)[UNITS], abs=2e-3
    )
    assert (lines.colours[~strong, 3] == np.float32(FAINT)).all()


def test_a_ridden_fish_sees_its_senses_but_not_its_springs(world, diagram, in_sight):
    i = in_sight[0]
    own = tuple(replace(view, without=i) for view in sights(world))
    lines = diagram("scaffold", i, own).lines
    assert (lines.colours[:, 3] == np.float32(FAINT)).all()
    assert len(diagram("perception", i, own).lines.ends) > 100


@pytest.mark.parametrize("display", [one for one in DISPLAYS if one != "stereo"])
def test_labels_stand_where_their_places_are_seen(world, display):
    rig = display_rig(display, SIZE)
    observer = cockpit(world.state.submarine, 1.0)
    seen = views(rig, observer)
    aside = np.cross(observer.forward, observer.up)
    near = observer.eye + 120.0 * observer.forward  # on the screen: both eyes see it in one place
    labels = [Label(near, "ahead"), Label(near - 240.0 * observer.forward, "astern")]
    labels.append(Label(near + 20.0 * aside + 10.0 * observer.up, "aside"))
    found = place_labels(rig, seen, labels)
    if display in ("panorama", "dome", "equirectangular"):
        assert found == []
        return
    assert {one.text for one in found} == {"ahead", "aside"}
    halves = {"side-by-side": [(80, 90), (240, 90)], "top-bottom": [(160, 45), (160, 135)]}
    expected = halves.get(display, [(160, 90)])
    ahead = sorted((one.x, one.y) for one in found if one.text == "ahead")
    assert ahead == [pytest.approx(place, abs=0.2) for place in sorted(expected)]
    right = sorted((one.x, one.y) for one in found if one.text == "aside")
    assert all(b[0] > a[0] and b[1] < a[1] for a, b in zip(ahead, right, strict=True))
    [view] = seen[:1]
    assert projected(view, []) == []


def test_lists_of_diagrams_are_checked():
    assert chosen_diagrams("frusta, control-mesh") == ("control mesh", "frusta")
    assert chosen_diagrams("") == ()
    with pytest.raises(UserError, match=r"scafold.*scaffold"):
        chosen_diagrams("scafold")
    assert {*MOST} <= {*DIAGRAMS}
