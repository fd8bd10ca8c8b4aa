"""Labels agree with each other, with closed forms and with the world at the next tick."""

import numpy as np
import pytest

import subsea
from subsea.frame.packet import KIND, instances_of
from subsea.lab.dataset.keypoints import NAMES
from subsea.lab.dataset.labelling import ABSENT, HIDDEN, OUTSIDE, VISIBLE
from subsea.rendering.fish.fishes import FishShape
from subsea.view.optics import pixel_grid
from subsea.view.retina import eyes_pose, fish_eyes

SIZE = (320, 240)
BENT = {"lens": (-0.2, 0.05, 0.001, -0.001, 0.0), "port": subsea.FlatPort(2.0, 0.6)}


@pytest.fixture(scope="module")
def world():
    world = subsea.load("schooling", seed=1)
    world.step(200)
    return world


def beside(world, fish):
    """A camera beside a fish, a little above it."""
    place, way = (one[fish].astype(float) for one in (world.fishes.position, world.fishes.velocity))
    aside = np.array([-way[1], way[0], 0.25 * np.hypot(way[0], way[1])])
    reach = 2.5 * world.fishes.length[fish] + 10.0
    return subsea.camera(place + reach * aside / np.linalg.norm(aside), place)


@pytest.fixture(scope="module")
def plain(world):
    return subsea.labels(world, beside(world, 17), size=SIZE)


@pytest.fixture(scope="module")
def through_a_port(world):
    return subsea.labels(world, beside(world, 17), size=SIZE, **BENT)


@pytest.fixture(params=["plain", "through_a_port"])
def labels(request):
    return request.getfixturevalue(request.param)


def values(labels):
    return 10000 + labels.fishes.number


def test_the_world_stays_as_it_is(world):
    before = world.checksum()
    first = subsea.labels(world, 3, size=(64, 48))
    assert world.checksum() == before
    again = subsea.labels(world, 3, size=(64, 48))
    for name in ("picture", "identity", "depth", "normal", "flow_forward", "flow_backward"):
        np.testing.assert_array_equal(getattr(first, name), getattr(again, name))


def test_a_visible_keypoint_lies_on_its_fishs_mask(labels):
    fishes = labels.fishes
    visible = np.argwhere(fishes.state == VISIBLE)
    assert len(visible) > 40
    for i, k in visible:
        x, y = np.rint(fishes.keypoints[i, k]).astype(int)
        around = labels.identity[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2]
        assert (around == values(labels)[i]).any()


def test_few_keypoints_vanish_where_nothing_hides_them(plain):
    """Only tips of tails that are seen edge-on, thinner than a pixel."""
    fishes = plain.fishes
    vanished = (fishes.state == HIDDEN) & (fishes.hidden_by == -1) & (fishes.pixels[:, None] > 300)
    assert vanished.sum() < 0.1 * (fishes.state == VISIBLE).sum()
    aside = fishes.whole[:, 2] > 1.5 * fishes.whole[:, 3]
    assert vanished[aside].sum() <= 0.03 * (fishes.state[aside] == VISIBLE).sum()


def test_a_hidden_keypoint_has_what_hides_it_nearer_at_its_pixel(labels):
    fishes = labels.fishes
    hidden = np.argwhere(fishes.state == HIDDEN)
    assert len(hidden) > 20
    for i, k in hidden:
        x, y = np.rint(fishes.keypoints[i, k]).astype(int)
        by = fishes.hidden_by[i, k]
        if by == values(labels)[i]:
            continue  # itself, perhaps by a flank that is seen at its edge
        if by == -1:
            assert not labels.depth[y, x] < fishes.depth[i, k] - 2.0
            continue
        assert labels.identity[y, x] == by
        assert labels.depth[y, x] < fishes.depth[i, k]
    own = fishes.hidden_by == values(labels)[:, None]
    eyes = [NAMES.index(name) for name in ("left_eye", "right_eye")]
    assert own[:, eyes].any()
    # No fish shows both eyes from the side.
    big = fishes.pixels > 800
    assert not (fishes.state[big][:, eyes] == VISIBLE).all(axis=1).all()
    assert (fishes.hidden_by[fishes.state != HIDDEN] == -1).all()


def test_states_say_where_keypoints_are(labels):
    fishes = labels.fishes
    width, height = SIZE
    inside = (fishes.keypoints > -0.5).all(axis=2)
    inside &= (fishes.keypoints < np.array([width, height]) - 0.5).all(axis=2)
    assert (inside == (fishes.state >= HIDDEN)).all()
    assert set(np.unique(fishes.state)) <= {ABSENT, OUTSIDE, HIDDEN, VISIBLE}
    assert np.isnan(fishes.keypoints[fishes.state == ABSENT]).all()


def test_eyes_lie_where_a_fish_looks_from(world, plain):
    """Its retinae are drawn from the middle between both eyes."""
    fishes = plain.fishes
    eyes = [NAMES.index(name) for name in ("left_eye", "right_eye")]
    for i in np.flatnonzero(fishes.pixels > 400):
        fish = int(fishes.number[i])
        middle = eyes_pose(world.internal, fish_eyes(world.internal, fish), 1.0).eye
        seen = plain.matrix[:3, :3] @ middle + plain.matrix[:3, 3]
        pixels = fishes.keypoints[i, eyes]
        # Of two points at depths a and b, the middle projects to the mean weighted by depth.
        depth = fishes.depth[i, eyes]
        between = (pixels * depth[:, None]).sum(axis=0) / depth.sum()
        np.testing.assert_allclose(between, plain.optics.project(seen), atol=0.3)
        assert depth.mean() == pytest.approx(seen[2], abs=0.05)


def test_the_snout_lies_before_the_tail(world, plain):
    fishes = plain.fishes
    snout, tail = (NAMES.index(name) for name in ("snout", "tail_root"))
    big = fishes.pixels > 300
    back = np.linalg.inv(plain.matrix)

    def place(k):
        z = fishes.depth[big, k]
        xy = (fishes.keypoints[big, k] - plain.optics.middle) / plain.optics.focal_px
        return np.column_stack([xy * z[:, None], z]) @ back[:3, :3].T

    way = world.fishes.velocity[fishes.number[big]]
    assert (((place(snout) - place(tail)) * way).sum(axis=1) > 0.0).all()


def test_the_box_of_a_mask_lies_in_the_whole_box(labels):
    fishes = labels.fishes
    seen = fishes.pixels > 0
    box, whole = fishes.box[seen], fishes.whole[seen]
    edge = 1.0 if labels.optics.straight else 1.6  # pixels; a remapped mask takes the nearest
    assert (box[:, :2] >= whole[:, :2] - edge).all()
    assert (box[:, :2] + box[:, 2:] <= whole[:, :2] + whole[:, 2:] + edge).all()
    # And nearly fills it where nothing hides the fish.
    free = (fishes.share[seen] > 0.999) & (whole[:, 2] > 1.5 * whole[:, 3])
    free &= (whole[:, 1] > 0.0) & (whole[:, :2] + whole[:, 2:] < SIZE).all(axis=1)
    if labels.optics.straight:
        assert free.any()
    area, most = (one[free, 2] * one[free, 3] for one in (box, whole))
    assert (area > 0.85 * most).all()
    if labels.optics.straight:
        assert np.mean(area / most) > 0.9


def test_visible_boxes_and_counts_are_those_of_the_identity_map(labels):
    fishes = labels.fishes
    for value, box, count in zip(values(labels), fishes.box, fishes.pixels, strict=True):
        mask = labels.identity == value
        assert mask.sum() == count
        if count:
            row, column = np.nonzero(mask)
            wide, high = np.ptp(column) + 1, np.ptp(row) + 1
            np.testing.assert_array_equal(box, [column.min(), row.min(), wide, high])
    shown = np.unique(labels.identity[labels.identity >= 10000])
    assert set(shown) <= set(values(labels).tolist())


def test_a_lone_fish_is_wholly_visible_and_one_behind_it_is_not(world):
    """Seen from one side, the share of a fish falls as a nearer one covers it."""
    labels = subsea.labels(world, beside(world, 17), size=SIZE)
    share = labels.fishes.share
    assert share[0] > 0.99  # the nearest
    assert (share >= 0.0).all()
    assert (share <= 1.0).all()
    assert share.min() < 0.7


def test_depth_agrees_with_the_vertices_of_bodies(world, plain):
    """Each vertex is at the depth of its pixel, or hidden by something nearer."""
    fishes = plain.fishes
    state = world.internal
    fish = fishes.number[:1].astype(np.int64)
    instances = instances_of(state, fish, 1.0)
    shape = FishShape(state.species, tuple(float(x) for x in state.library.recorded_length), 0)
    places = shape.at(instances, state.library.control_points).places[0].astype(float)
    body = shape._vertices[:, 12] == 0  # fins are translucent
    places = places[body & shape.present[int(instances[0, KIND])]]
    points = places @ plain.matrix[:3, :3].T + plain.matrix[:3, 3]
    pixels = plain.optics.project(points)
    mine = plain.identity == 10000 + fish[0]
    inside = (pixels > 1).all(axis=1) & (pixels < np.array(SIZE) - 2).all(axis=1)
    column, row = np.rint(pixels[inside]).astype(int).T
    on = mine[row, column]
    gap = points[inside][on, 2] - plain.depth[row, column][on]
    assert (gap > -0.6).mean() > 0.95  # cm; the tail is thinner than a pixel
    assert (np.abs(gap) < 0.3).mean() > 0.25  # those that face the camera


def test_flow_is_the_way_of_vertices_from_tick_to_tick(world, labels):
    """The second way: step the world, and project the same vertices again."""
    state = world.internal
    fishes = labels.fishes
    fish = fishes.number[fishes.pixels > 300].astype(np.int64)
    shape = FishShape(state.species, tuple(float(x) for x in state.library.recorded_length), 0)

    def seen(share):
        instances = instances_of(state, fish, share)
        places = shape.at(instances, state.library.control_points).places.astype(float)
        return places @ labels.matrix[:3, :3].T + labels.matrix[:3, 3]

    now, before = seen(1.0), seen(0.0)
    kept = world.snapshot()
    world.step(1)
    after = seen(1.0)
    world.restore(kept)
    pixels = labels.optics.project(now)
    for other, flow in ((after, labels.flow_forward), (before, labels.flow_backward)):
        way = labels.optics.project(other) - pixels
        errors = []
        for i, number in enumerate(fish):
            inside = (pixels[i] > 0).all(axis=1) & (pixels[i] < np.array(SIZE) - 1).all(axis=1)
            inside &= shape.present[state.state.fishes.species[number]]
            at = np.flatnonzero(inside)
            column, row = np.rint(pixels[i, at]).astype(int).T
            front = np.abs(labels.depth[row, column] - now[i, at, 2]) < 0.15
            front &= labels.identity[row, column] == 10000 + number
            errors.append(np.linalg.norm(flow[row, column] - way[i, at], axis=1)[front])
        error = np.concatenate(errors)
        assert len(error) > 200
        assert np.median(error) < 0.03
        assert np.quantile(error, 0.95) < 0.25
        assert np.linalg.norm(way, axis=-1).max() > 1.0


def test_flow_of_a_moving_camera_over_still_stone(world):
    """A camera that moves 2 cm ahead: points flow from the middle by their distance from it."""
    pose = beside(world, 17)

    def moving(world_now, share):
        ticks = world_now.tick + share - 1.0
        return pose._replace(eye=pose.eye + 2.0 * (ticks - 200) * pose.forward)

    labels = subsea.labels(world, moving, size=SIZE)
    still = np.isin(labels.category, [labels.classes.index(n) for n in ("seabed", "pillar")])
    assert still.sum() > 1000
    from_middle = pixel_grid(SIZE) - labels.optics.middle
    z = labels.depth[..., None].astype(float)
    for flow, step in ((labels.flow_forward, 2.0), (labels.flow_backward, -2.0)):
        expected = from_middle * (1.0 / (1.0 - step / z) - 1.0)
        np.testing.assert_allclose(flow[still], expected[still], atol=1e-3)
    water = labels.category == labels.classes.index("water")
    assert np.abs(labels.flow_forward[water]).max() < 1e-3


def test_normals_face_the_camera_and_are_those_of_the_depth_map(plain):
    ways = plain.optics.points(np.full(SIZE[::-1], 1.0))
    solid = np.isfinite(plain.depth)
    assert ((plain.normal * ways).sum(axis=-1)[solid] < 1e-3).all()
    np.testing.assert_allclose(np.linalg.norm(plain.normal[solid], axis=-1), 1.0, atol=1e-5)
    assert np.isnan(plain.normal[~solid]).all()
    points = plain.optics.points(plain.depth.astype(np.float64))
    across = points[1:-1, 2:] - points[1:-1, :-2]
    down = points[2:, 1:-1] - points[:-2, 1:-1]
    normal = np.cross(down, across)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    sand = plain.category == plain.classes.index("seabed")
    sand = sand[1:-1, 1:-1] & sand[2:, 1:-1] & sand[:-2, 1:-1] & sand[1:-1, 2:] & sand[1:-1, :-2]
    agreement = (normal * plain.normal[1:-1, 1:-1]).sum(axis=-1)[sand]
    assert np.median(agreement) > 0.999
    assert np.quantile(agreement, 0.1) > 0.98


def test_classes_are_kinds_and_species(labels):
    fish = labels.identity >= 10000
    assert fish.any()
    assert (labels.category[fish] == labels.classes.index("Yellowback fusilier")).all()
    assert (labels.category[labels.identity == 2] == labels.classes.index("seabed")).all()
    assert labels.name(10017) == "fish 17"
    assert labels.name(2) == "seabed"
    rock = labels.identity[(labels.identity >= 300) & (labels.identity < 1000)]
    assert labels.name(int(rock[0])) == f"rock {rock[0] - 300}"


def test_a_rig_gives_labels_of_each_camera_and_the_pilots_is_the_default(world):
    pose = beside(world, 17)
    right = np.cross(pose.forward, pose.up)
    aside = pose._replace(eye=pose.eye + 10.0 * right)
    both = subsea.labels(world, [pose, aside, None], size=SIZE, flow=False)
    assert len(both) == 3
    assert np.isnan(both[0].flow_forward).all()
    # Rectified: a keypoint of the right camera lies f b / z farther left.
    left, other = both[0].fishes, both[1].fishes
    j = other.number.tolist().index(int(left.number[0]))
    shift = left.keypoints[0] - other.keypoints[j]
    f = both[0].optics.focal_px
    np.testing.assert_allclose(shift[:, 0], 10.0 * f / left.depth[0], rtol=1e-4)
    np.testing.assert_allclose(shift[:, 1], 0.0, atol=1e-3)
    pilot = subsea.render(world, size=SIZE)
    assert both[2].picture.shape == pilot.shape


def test_a_camera_in_stone_or_sand_is_an_error_of_one_line(world):
    x, y, radius, top = world.sea.pillars[0]
    inside = subsea.camera((x, y, top - 0.2 * radius), (0.0, 0.0, -100.0))
    with pytest.raises(subsea.UserError, match=r"inside a stone; move") as fault:
        subsea.labels(world, inside)
    assert "\n" not in str(fault.value)
    under = subsea.camera((0.0, 0.0, -5000.0), (0.0, 10.0, -4000.0))
    with pytest.raises(subsea.UserError, match="inside the seabed"):
        subsea.labels(world, under)


def test_stone_hides_fishes_and_says_so(world):
    """From behind a pillar, in line with each fish in turn."""
    x, y, radius, top = world.sea.pillars[0]
    hidden = set()
    for fish in range(0, 36, 4):
        place = world.fishes.position[fish].astype(float)
        away = np.array([x, y]) - place[:2]
        eye = np.array([x, y]) + (radius + 40.0) * away / np.linalg.norm(away)
        labels = subsea.labels(
            world, subsea.camera((*eye, min(place[2], top - 20.0)), place), size=SIZE, flow=False
        )
        fishes = labels.fishes
        for i in np.flatnonzero(fishes.pixels == 0):
            inside = fishes.state[i] >= HIDDEN
            assert (fishes.state[i][inside] == HIDDEN).all()
            assert np.isnan(fishes.box[i]).all()
            assert fishes.share[i] == 0.0
            by = fishes.hidden_by[i][inside]
            hidden |= {labels.name(int(one)).split()[0] for one in by[by >= 0]}
    assert "pillar" in hidden


def test_other_bad_cameras_are_errors(world):
    with pytest.raises(ValueError, match="fish 99"):
        subsea.labels(world, 99)
    with pytest.raises(TypeError, match=r"subsea\.camera"):
        subsea.labels(world, lambda world, share: None)
    with pytest.raises(ValueError, match="size"):
        subsea.labels(world, size=(0, 10))
