"""The packet: what drawing sees of a world."""

import msgspec
import numpy as np
import pytest

from subsea.frame import packet as frame
from subsea.kernels.threads import use_threads
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import SeaweedTable
from subsea.state import HANGING, HOOKED, LANDED, NOBODY, SINKING, STOWED
from subsea.submarine.vessel import NEUTRAL, Helm
from subsea.view import culling, levels
from subsea.view.display_rigs import cockpit, views_for
from subsea.view.levels import empty_lod_state
from subsea.view.rig import pose_from_angles
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S


@pytest.fixture(scope="module")
def world():
    world = create_world(load_scenario("peaceful")[0])
    for _ in range(40):
        step(world, Helm(surge=0.5))
    return world


def _pack(world, alpha=0.5, memory=None, **options):
    views = views_for("mono", (640, 360), cockpit(world.state.submarine, alpha))
    return frame.pack(world, views, alpha, frame.PackOptions(**options), memory=memory)


def test_the_number_of_threads_does_not_matter(world, monkeypatch):
    for module in (frame, culling, levels):
        monkeypatch.setattr(module, "LEAST_PART", 3)
    packets = []
    for threads in (1, 3):
        use_threads(threads)
        memory = empty_lod_state(len(world.state.fishes.species))
        packets += [_pack(world, alpha, memory) for alpha in (0.0, 1.0)]
    use_threads()
    for one, other in zip(packets[:2], packets[2:], strict=True):
        np.testing.assert_array_equal(one.instances, other.instances)
        assert one.batches == other.batches
        assert len(one.instances) > 20


def test_without_culling_every_fish_is_there_once(world):
    packet = _pack(world, culling=False)
    fishes = world.state.fishes
    assert packet.hidden == 0
    np.testing.assert_array_equal(
        np.sort(packet.instances[:, frame.IDENTITY]), np.sort(fishes.identity)
    )


def test_a_record_names_its_fish(world):
    packet = _pack(world)
    number = packet.instances[:, frame.FISH].astype(int)
    np.testing.assert_array_equal(
        packet.instances[:, frame.IDENTITY], world.state.fishes.identity[number]
    )
    assert len(set(number)) == len(number)


def test_culling_hides_some_and_keeps_the_rest(world):
    packet, everybody = _pack(world), _pack(world, culling=False)
    assert packet.hidden + len(packet.instances) == len(everybody.instances)
    assert 0 < packet.hidden < len(everybody.instances)


def test_batches_cover_the_instances_in_order(world):
    packet = _pack(world)
    ends = [0]
    for batch in packet.batches[0]:
        assert batch.first == ends[-1]
        ends.append(batch.first + batch.count)
    assert ends[-1] == len(packet.instances)
    levels = [batch.level for batch in packet.batches[0]]
    assert levels == sorted(set(levels), reverse=True)
    assert len(levels) > 1
    rows, kinds = packet.instances[:, [frame.ROW_A, frame.KIND]].astype(int).T
    # Bends have rows behind the recorded ones; their phase is a row of the straight swim.
    library = world.library
    rows = np.where(library.level[rows] != 0, library.straight[rows], rows)
    first = library.first[kinds, 0]
    ends = np.append(library.first[:, 0], library.veer[library.veer >= 0].min())
    assert ((rows >= first) & (rows < ends[kinds + 1])).all()


def test_without_lod_all_are_tessellated(world):
    assert {batch.level for batch in _pack(world, lod=False).batches[0]} == {0}


def test_detail_is_a_factor_on_the_pixels(world):
    def mean(packet):
        return sum(b.level * b.count for b in packet.batches[0]) / len(packet.instances)

    assert mean(_pack(world, detail=3.0)) < mean(_pack(world)) < mean(_pack(world, detail=0.3))


def test_with_a_memory_levels_fade_and_without_they_do_not(world):
    """While the camera comes nearer: records double, and their shares are each other's rest."""
    memory = empty_lod_state(len(world.state.fishes.species))
    first = _pack(world, memory=memory, detail=0.5)
    assert not any(batch.fading for batch in first.batches[0])
    alone = _pack(world, detail=1.5)
    assert not any(batch.fading for batch in alone.batches[0])
    second = _pack(world, memory=memory, detail=1.5)
    assert len(second.instances) > len(alone.instances) == len(first.instances)
    assert second.hidden == alone.hidden
    for value in np.unique(second.instances[:, frame.IDENTITY]):
        mine = second.instances[second.instances[:, frame.IDENTITY] == value]
        if len(mine) == 2:
            shares = np.sort(mine[:, frame.FADE])
            assert shares[1] - shares[0] == pytest.approx(1.0)
            np.testing.assert_array_equal(*np.delete(mine, frame.FADE, axis=1))


@pytest.mark.parametrize(("alpha", "prefix"), [(0.0, "previous_"), (1.0, "")])
def test_the_ends_of_the_interval_are_the_ticks(world, alpha, prefix):
    packet = _pack(world, alpha, culling=False)
    fishes = world.state.fishes
    order = [int(np.flatnonzero(fishes.identity == v)[0]) for v in packet.instances[:, 11]]
    np.testing.assert_allclose(
        packet.instances[:, frame.POSITION], getattr(fishes, prefix + "position")[order], atol=1e-4
    )
    turn = (
        packet.instances[:, frame.ORIENTATION] * getattr(fishes, prefix + "orientation")[order]
    ).sum(axis=1)
    np.testing.assert_allclose(np.abs(turn), 1.0, atol=1e-5)
    assert packet.time_s == pytest.approx((39 + alpha) * TICK_S)


@pytest.fixture(scope="module")
def lively():
    """A world in which half the fishes or more are simulated; the others row, turn or burst."""
    world = create_world(load_scenario("peaceful")[0], live=60, live_reach_cm=np.inf)
    for _ in range(600):
        step(world, Helm(surge=0.5))
        if world.state.fishes.live.sum() >= 30:
            break
    assert world.state.fishes.live.sum() >= 30
    return world


def test_simulated_fishes_bring_their_own_rows(lively):
    packet = _pack(lively, 1.0, culling=False)
    fishes, library, live = lively.state.fishes, lively.library, lively.state.live
    assert packet.live_row == len(library.entry)
    assert packet.live_points.shape[1:] == (426, 3)
    assert len(packet.live_points) > 2 * np.flatnonzero(live.fish >= 0).max()
    for slot in np.flatnonzero(live.fish >= 0):
        i = live.fish[slot]
        for row in (2 * slot, 2 * slot + 1):
            expected = library.coupling.weights[fishes.species[i]] @ live.nodes[row]
            np.testing.assert_allclose(packet.live_points[row], expected, atol=1e-5)


def test_between_ticks_a_simulated_fish_mixes_its_last_two_poses(lively):
    packet = _pack(lively, 0.25, culling=False)
    simulated = lively.state.fishes.live[packet.instances[:, frame.FISH].astype(int)]
    records = packet.instances[simulated]
    assert len(records) >= 30
    rows = records[:, [frame.ROW_A, frame.ROW_B]].astype(int) - packet.live_row
    assert (rows >= 0).all()
    np.testing.assert_array_equal(rows[:, 0] // 2, rows[:, 1] // 2)
    np.testing.assert_array_equal(np.abs(rows[:, 0] - rows[:, 1]), 1)
    np.testing.assert_allclose(records[:, frame.WEIGHT], 0.25, atol=1e-6)


def test_without_simulated_fishes_the_packet_has_no_rows(world):
    assert len(_pack(world).live_points) == 0


@pytest.mark.nightly
def test_a_fish_that_was_out_of_sight_comes_back_as_its_seen_twin():
    """Views change no fish: place, roll and pose are those of a fish always seen.

    SMC table 1 lets invisible fishes skip pose and gliding. Here poses are evaluated for visible
    fishes only, by the shaders; gliding costs no more than a step of playback and is not skipped.
    """
    seen, unseen = (create_world(load_scenario("peaceful")[0], fish=30) for _ in range(2))
    for tick in range(200):
        for world in (seen, unseen):
            step(world, Helm(yaw=0.3))
        drawn = _pack(seen, culling=False)
        if tick % 50 == 0:
            _pack(unseen)  # the twin is drawn now and then, and partly culled
    np.testing.assert_array_equal(_pack(unseen, culling=False).instances, drawn.instances)


def test_the_hook_is_there_while_it_is_in_the_water(world):
    sea = world.state.sea
    there = sea._replace(
        tackle=np.array([1.0, 2.0, 300.0, 30.0, 0.0]),
        hook=np.array([1.0, 2.0, -50.0]),
        catch=np.array([STOWED, NOBODY]),
    )
    seen = {}
    world.state.sea = there
    for state in (STOWED, SINKING, HANGING, HOOKED, LANDED):
        there.catch[0] = state
        packet = _pack(world, alpha=0.25)
        seen[state] = None if packet.hook is None else (round(packet.hook[2], 4), packet.bait)
    world.state.sea = sea
    ago = 0.75 * TICK_S * 30.0
    assert seen == {
        STOWED: None,
        SINKING: (round(-50 + ago, 4), True),
        HANGING: (-50.0, True),
        HOOKED: (round(-50 - ago, 4), False),
        LANDED: None,
    }


@pytest.fixture(scope="module")
def overgrown():
    """The peaceful bay with a bed of seaweed before the submarine, moved by the current."""
    scenario = load_scenario("peaceful")[0]
    x, y, _ = scenario.submarine.position_cm
    bed = SeaweedTable(position_cm=(x + 150.0, y), spread_cm=150.0, clusters=12, leaves=4)
    world = create_world(msgspec.structs.replace(scenario, seaweed=[bed]), fish=10)
    for _ in range(60):
        step(world, NEUTRAL)
    return world


def _leaves_of(world, heading, alpha=1.0, **options):
    submarine = world.state.submarine
    eye = pose_from_angles(submarine.position, heading, -0.5)
    views = views_for("mono", (1280, 720), eye)
    return frame.pack(world, views, alpha, frame.PackOptions(**options))


def test_leaves_lie_between_the_last_tick_and_this_one(overgrown):
    weed = overgrown.state.seaweed
    assert np.abs(weed.node - weed.previous).max() > 0.05
    for alpha in (0.0, 0.3, 1.0):
        packet = _leaves_of(overgrown, 0.0, alpha, culling=False, lod=False)
        assert packet.fine_leaves == len(packet.leaves) == 48
        expected = weed.previous + alpha * (weed.node - weed.previous)
        np.testing.assert_allclose(packet.leaves[:, :8, :3], expected, atol=1e-3)
        np.testing.assert_array_equal(packet.leaves[:, 8:].reshape(48, 8), weed.look)


def test_seaweed_out_of_sight_is_left_out_and_what_is_far_is_coarse(overgrown):
    ahead, astern = (_leaves_of(overgrown, heading) for heading in (0.0, np.pi))
    assert len(ahead.leaves) > 15
    assert len(astern.leaves) < 10
    near = np.linalg.norm(ahead.leaves[:, 0, :3] - overgrown.state.submarine.position, axis=1)
    assert ahead.fine_leaves > 0
    if ahead.fine_leaves < len(ahead.leaves):
        assert near[: ahead.fine_leaves].mean() < near[ahead.fine_leaves :].mean()
    submarine = overgrown.state.submarine.position.copy()
    overgrown.state.submarine.position[0] -= 900.0
    far = _leaves_of(overgrown, 0.0)
    overgrown.state.submarine.position[:] = submarine
    assert far.fine_leaves == 0


def test_growth_is_the_share_of_the_clusters_and_less_is_a_part_of_more(overgrown):
    def roots(growth):
        packet = _leaves_of(overgrown, 0.0, culling=False, lod=False, growth=growth)
        return {tuple(root) for root in packet.leaves[:, 0, :3].round(3)}

    none, some, more, everything = (roots(growth) for growth in (0.0, 0.4, 0.7, 1.0))
    assert not none
    assert some < more < everything
    assert len(everything) == 48
    assert abs(len(some) - 0.4 * 48) <= 8  # whole clusters of four


def test_only_bites_in_sight_are_packed(world):
    sea = world.state.sea
    before, place, ways = sea.stock.copy(), sea.site_place[0].astype(float), []
    sea.stock[:] = 0.5
    for heading in (0.0, np.pi):
        pose = pose_from_angles(place - (50.0, 0.0, 0.0), heading, 0.0)
        bites = frame.pack(world, views_for("mono", (640, 360), pose), 0.5).bites
        ways.append((bites[:, :3] - pose.eye) @ pose.forward)
    sea.stock[:] = before
    assert len(ways[0]) > 0
    assert len(ways[0]) + len(ways[1]) <= frame.MOST_BITES
    assert (np.concatenate(ways) > -frame.BITE_CM).all()
