"""Record the frames of a scene: fishes, seaweed and camera, as `subsea film` shows them."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from subsea.base import interrupts
from subsea.base.arrays import Array
from subsea.base.progress import progress
from subsea.dive.captions import caption_of
from subsea.dive.directed_camera import is_cut
from subsea.export.conventions import continuous
from subsea.export.plant_motion import key_frames
from subsea.export.scene import SceneCamera
from subsea.frame.packet import ROW_A, ROW_B, PackOptions, pack
from subsea.geometry.rotation import from_matrix
from subsea.media.film import reach
from subsea.view.camera import FAR_CM, NEAR_CM
from subsea.view.display_rigs import VERTICAL_FOV, cockpit, display_rig
from subsea.view.follow import FollowCamera, follow_fish
from subsea.view.rig import CameraPose, views
from subsea.world.step import Order
from subsea.world.world import World

POSES = [ROW_A, ROW_B]
EVERY_FISH = PackOptions(growth=0.0, culling=False, lod=False)


class Take(NamedTuple):
    """The fishes, the seaweed and the camera of one frame."""

    rows: Array  # (m, 30) float32, of the fishes in the sea
    simulated: Array  # (k, 426, 3) float32 cm: poses that follow those of earlier frames
    leaves: Array | None  # (L, NODES, 3) float32 cm: nodes of all seaweed, at keys of its motion
    observer: CameraPose
    caption: str


def record_frames(
    world: World, times: Sequence[float], steer: Callable[[World], Order], follow: int | None,
    rate: float, size: tuple[int, int], after: Callable[[], None] = lambda: None,
) -> tuple[list[Take], SceneCamera]:  # fmt: skip
    """Step a world through the instants `times`; return what each frame shows, and the camera.

    `steer` steers the submarine; `follow` is the number of a fish to look at. `rate` is the number
    of frames in a second, `size` that of the film's picture. `after` is called after each tick.
    """
    rig = display_rig("mono", size)
    camera: FollowCamera | None = None
    takes: list[Take] = []
    cuts = []
    keys = {*key_frames(len(times), rate).tolist()}
    seaweed = world.state.seaweed
    simulated = 0  # poses in earlier frames
    with interrupts.deferred_interrupts() as check, progress(len(times), "frame") as done:
        for k, instant in enumerate(times):
            alpha = reach(world, instant, steer, check, after=after)
            observer = cockpit(world.state.submarine, alpha)
            if follow is not None and world.state.fishes.alive[follow]:
                camera, observer = follow_fish(world, follow, alpha, camera)
            if takes and is_cut(takes[-1].observer, observer, 1.0 / rate):
                cuts.append(k)
            packet = pack(world, views(rig, observer), alpha, EVERY_FISH)
            rows = packet.instances.copy()
            rows[:, POSES] += simulated * (rows[:, POSES] >= packet.live_row)
            simulated += len(packet.live_points)
            said = caption_of(world, alpha)
            words = said.words if said.opacity > 0.0 else ""
            leaves = None
            if k in keys:
                leaves = seaweed.previous + np.float32(alpha) * (seaweed.node - seaweed.previous)
            takes.append(Take(rows, packet.live_points.copy(), leaves, observer, words))
            done()
    observers = [take.observer for take in takes]
    axes = np.array([(pose.axes[0], pose.up, -pose.forward) for pose in observers])
    track = SceneCamera(
        position=np.array([pose.eye for pose in observers], np.float64),
        rotation=continuous(from_matrix(np.swapaxes(axes, 1, 2))),
        height_rad=float(VERTICAL_FOV),
        aspect=size[0] / size[1],
        size=size,
        near_cm=NEAR_CM,
        far_cm=FAR_CM,
        cuts=tuple(cuts),
    )
    return takes, track
