"""Simulated fishes are drawn by the same path as recorded ones."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.frame import packet as frame
from subsea.geometry.rotation import x_axis
from subsea.motor.pose import control_points_world
from subsea.rendering.fish.fishes import TABLE_ROWS
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import views_for
from subsea.view.rig import pose_from_angles
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.daily import only

SIZE = (240, 160)


@pytest.fixture(scope="module")
def world(quiet):
    """A handful of fishes, most of them simulated."""
    world = create_world(load_scenario(quiet)[0], fish=6, live=6, live_reach_cm=np.inf)
    for _ in range(300):
        step(world, NEUTRAL)
        if world.state.fishes.live.sum() >= 3:
            break
    assert world.state.fishes.live.sum() >= 3
    return world


def _packet(world, i, alpha):
    """Fish i from its right, a body length and a half away."""
    fishes = world.state.fishes
    ahead = x_axis(fishes.orientation[i])
    heading = np.arctan2(ahead[1], ahead[0]) + np.pi / 2
    away = np.array([np.cos(heading), np.sin(heading), 0.0])
    eye = fishes.position[i] - 1.5 * fishes.length[i] * away
    return frame.pack(world, views_for("mono", SIZE, pose_from_angles(eye, heading, 0.0)), alpha)


@pytest.mark.nightly
@pytest.mark.parametrize("alpha", only([0.4], [0.0, 0.4, 1.0]))
def test_the_picture_is_that_of_rows_that_were_there_from_the_start(drawn, world, alpha):
    packet = _packet(world, np.flatnonzero(world.state.fishes.live)[0], alpha)
    scene = frame.make_scene(world)
    table = scene.control_points.copy()
    blank, full = table.copy(), table
    blank[packet.live_row :] = 0.0
    full[packet.live_row : packet.live_row + len(packet.live_points)] = packet.live_points
    nothing = np.zeros((0, 426, 3), np.float32)
    live = drawn(packet, scene=replace(scene, control_points=blank))
    rows = replace(packet, live_points=nothing)
    np.testing.assert_array_equal(live, drawn(rows, scene=replace(scene, control_points=full)))


@pytest.mark.nightly
def test_a_table_may_have_more_rows_than_a_texture(drawn, world):
    """Rows stand in blocks side by side; here simulated fishes cross the border of two blocks."""
    packet = _packet(world, np.flatnonzero(world.state.fishes.live)[0], 0.4)
    scene = frame.make_scene(world)
    more = 5 * TABLE_ROWS - packet.live_row - 1
    assert more + packet.live_row > 16_384  # the greatest height of many drivers
    records = packet.instances.copy()
    records[:, [frame.ROW_A, frame.ROW_B]] += more
    blank = np.zeros((more, *scene.control_points.shape[1:]), np.float32)
    table = np.concatenate([blank, scene.control_points])
    far = replace(packet, instances=records, live_row=packet.live_row + more)
    usual = drawn(packet, scene=scene)
    np.testing.assert_array_equal(drawn(far, scene=replace(scene, control_points=table)), usual)


def test_the_silhouette_is_where_the_oracle_has_the_control_points(drawn, world):
    """At a tick, the box around the drawn fish equals that of its projected points."""
    fishes = world.state.fishes
    one = int(np.flatnonzero(fishes.live)[0])
    packet = _packet(world, one, 1.0)
    records = packet.instances.copy()
    records[:, frame.FINS] = 0.0  # paired fins are not control points: fold them to the body
    mine = np.flatnonzero(np.abs(records[:, frame.POSITION] - fishes.position[one]).max(1) < 1e-3)
    assert len(mine) == 1
    away, scene = records.copy(), frame.make_scene(world)
    away[mine, frame.POSITION] += 1e5
    shown, hidden = (
        drawn(replace(packet, instances=each), scene=scene) for each in (records, away)
    )
    seen = np.argwhere(np.abs(shown - hidden).max(axis=2) > 3)
    view = packet.views[0]
    points = control_points_world(fishes, world.library, one)
    clip = np.c_[points, np.ones(len(points))] @ (view.projection @ view.view).T
    across, up = (clip[:, :2] / clip[:, 3:]).T
    x, y = (across + 1) / 2 * SIZE[0], (1 - up) / 2 * SIZE[1]
    assert np.ptp(x) > 50
    for pixels, expected in ((seen[:, 1], x), (seen[:, 0], y)):
        assert pixels.min() == pytest.approx(expected.min(), abs=8)
        assert pixels.max() == pytest.approx(expected.max(), abs=8)
