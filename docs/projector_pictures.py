"""Draw the test pattern for the projectors of a theatre."""

import numpy as np

from subsea.base.arrays import Bytes
from subsea.dive.start import headless
from subsea.rendering.output.target import ResolvePass
from subsea.view.rig import CameraRig
from subsea.view.test_pattern import lineup


def projector_pictures(rig: CameraRig) -> list[Bytes]:
    """Draw the test pattern as each projector gets it: pictures (h, w, 3), top row first."""
    pictures = []
    with headless() as context:
        data = np.ascontiguousarray(lineup(rig)[::-1]).tobytes()
        texture = context.texture(rig.canvas, 3, data, alignment=1)
        resolve = ResolvePass(context, rig.patches)
        for number, patch in enumerate(rig.patches):
            size = rig.outputs[patch.output]
            target = context.simple_framebuffer(size)
            target.clear()
            resolve.draw(texture, target, size, number, unit=None)
            read = np.frombuffer(target.read(alignment=1), np.uint8)
            pictures.append(read.reshape(size[1], size[0], 3)[::-1])
        resolve.release()
    return pictures
