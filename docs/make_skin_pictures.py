"""Operate the window of `subsea skin`: skin-{window,whole,relax}.jpg.

Run from the root of a checkout, where there is a display (or by xvfb-run -a -s "-screen 0
1280x800x24"): python docs/make_skin_pictures.py
"""

import tempfile
from contextlib import closing
from pathlib import Path

import numpy as np
from picture_files import output_folder, save
from PIL import Image
from skin_accuracy import CASES, made

from subsea.studio import mesh_edit
from subsea.studio.deformable_mesh import BODY
from subsea.studio.mesh_edit import MeshNode
from subsea.studio.photograph import read_photograph
from subsea.studio.skin_editor.window import SkinEditor
from subsea.studio.tool_window import ToolWindow

SIZE, FRAME_S = (1280, 800), 0.04
CASE, SPECIES = "gravel", "blue_tang"
TIPS = MeshNode(BODY, 0, 20), MeshNode(BODY, 8, 20)  # of the tail, which are as dark as the gravel
AFTER = 0, 12, 120  # frames of the simulation, for its strip

folder = output_folder()


class Hand:
    """Moves the pointer of a window, and draws its frames."""

    def __init__(self, window):
        self.window, self.canvas = window, window.tool.canvas

    def frames(self, count):
        """Draw some frames."""
        for _ in range(count):
            self.window.frame(FRAME_S)

    def rest(self):
        """Draw until background work is done."""
        self.frames(3)
        while self.window.busy or self.window.tool.working:
            self.frames(1)
        self.frames(3)

    def go(self, place, frames=2):
        """Point at a position in the photograph."""
        x, y = self.canvas.view.on_screen(place)
        self.window.gui.pointed(float(x), float(y))
        self.frames(frames)

    def press(self, down):
        """Press or release the left button."""
        self.window.gui.pressed(0, down)
        self.frames(3)

    def drag(self, begin, end, steps=10, let_go=True):
        """Drag between two positions."""
        self.go(begin)
        self.press(True)
        for share in np.linspace(0.0, 1.0, steps):
            self.go(np.asarray(begin) + share * (np.asarray(end) - begin))
        self.frames(10)
        if let_go:
            self.press(False)

    def save(self, name, box=None):
        """Save the window or a part of it."""
        picture = Image.fromarray(self.window.window_set.picture())
        save(picture if box is None else picture.crop(box), folder / f"skin-{name}.jpg")

    def seen(self, box):
        """A part of the window."""
        return np.asarray(Image.fromarray(self.window.window_set.picture()).crop(box))


with tempfile.TemporaryDirectory() as temporary:
    photo, truth = Path(temporary) / "blue-tang.png", made(CASES[CASE])
    Image.fromarray(truth.photograph.colour).save(photo)
    photograph = read_photograph(photo)
    make = lambda window: SkinEditor(window, photograph, SPECIES)  # noqa: E731
    with closing(ToolWindow(f"subsea skin  {photo.name}", make, SIZE)) as window:
        hand, editor = Hand(window), window.tool
        document = editor.document
        hand.rest()
        canvas = editor.canvas.view
        (left, top), (wide, high) = canvas.place, canvas.size
        view = round(left), round(top), round(left + wide), round(top + high)
        # No edge was found at the end of the tail: correct it by hand.
        share = editor.canvas.box[2] / photograph.colour.shape[1]
        rows, columns = np.nonzero(truth.mask)
        for tip, half in zip(TIPS, (rows < rows.mean(), rows > rows.mean()), strict=True):
            far = columns[half].argmax()
            there = share * np.array([columns[half][far], rows[half][far]])
            here = mesh_edit.node_places(document.meshes, [tip])[0]
            hand.drag(here, there, let_go=False)
            if tip == TIPS[1]:
                hand.save("window")
            hand.press(False)
            document.meshes = mesh_edit.with_anchor(document.meshes, tip, tuple(there))
            document.record()
        hand.rest()
        # The whole is moved and turned.
        document.meshes = mesh_edit.without_anchors(document.meshes)
        editor.canvas.mode = "whole"
        frame = mesh_edit.transform_box(document.meshes)
        hand.drag(frame.middle, frame.middle + (5.0, -7.0))
        frame = mesh_edit.transform_box(document.meshes)
        hand.drag(frame.knob, frame.knob + (6.0, 0.0), let_go=False)
        hand.save("whole", view)
        hand.press(False)
        # And relaxes.
        editor.canvas.mode = "pull"
        document.sliders = document.sliders._replace(smoothing=8.0)
        hand.go((5.0, 5.0))
        hand.rest()
        strip = []
        document.relax(True)
        for frames in np.diff((0, *AFTER), prepend=0)[1:]:
            hand.frames(int(frames))
            strip.append(hand.seen(view)[::2, ::2])
        editor.canvas.edges = True
        hand.frames(60)
        strip.append(hand.seen(view)[::2, ::2])
        rows = [np.hstack(strip[k : k + 2]) for k in (0, 2)]
        save(Image.fromarray(np.vstack(rows)), folder / "skin-relax.jpg")
