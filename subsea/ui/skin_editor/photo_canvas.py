"""The photograph with the meshes over it, and what the mouse does to them."""

from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from subsea.core.arrays import Array
from subsea.fish.photo import mesh_edit
from subsea.fish.photo.deformable_mesh import BODY, DORSAL, VENTRAL, Field, Net, copied, meshes
from subsea.fish.photo.mesh_edit import Node
from subsea.fish.photo.side_view import finer
from subsea.render.gl.image_texture import ImageTexture
from subsea.ui.gui import GLASS, INK, MARK
from subsea.ui.viewport2d import Canvas, Touch

if TYPE_CHECKING:
    from subsea.ui.skin_editor.window import Dressing

Hand = Literal["pull", "anchor", "whole"]

HANDS: dict[Hand, tuple[str, str]] = {
    "pull": (
        "Pull",
        "Drag a node: the mesh follows. Shift-click: an anchor holds it, or lets it go. "
        "Wheel: zoom. Drag beside the mesh: move the view.",
    ),
    "anchor": (
        "Anchor",
        "Click a node: an anchor holds it, or lets it go. Drag it: it is held where it is put.",
    ),
    "whole": (
        "Move, turn, scale",
        "Drag inside the frame: move all. Corners: scale. Sides: stretch. The knob: turn.",
    ),
}
INKS = {BODY: MARK, DORSAL: (1.0, 0.80, 0.36), VENTRAL: (0.72, 0.95, 0.45)}
HELD = (1.0, 0.45, 0.25)  # of anchors, and of the spring of the mouse
FAINT = 0.35  # how plain those parts are that hands do not touch
GRIPS = 9  # of the frame: corners, sides, knob
PULLS = 40  # steps of the springs in a frame, under the hand
CLICK = 3.0  # pointer units: a hand that moved less has clicked


class Easel:
    """What stands on it, and which hand is used."""

    def __init__(self, context: Any, colour: NDArray[np.uint8], shape: tuple[int, ...]) -> None:
        """With a photograph (h, w, 3) that is seen whole; its pixels count as those of `shape`."""
        self._context = context
        height, width = shape[:2]
        self.box = -0.5, -0.5, width - 0.5, height - 0.5  # places count the middles of pixels
        self.canvas = Canvas(self.box)
        self.hand: Hand = "pull"
        self.parts: tuple[str, ...] = (BODY, DORSAL, VENTRAL)  # that hands touch
        self.edges = False  # whether edges are shown instead of the photograph
        self.lines = True  # whether the meshes' inner lines are drawn
        self._photograph = ImageTexture(context, colour)
        self._field: ImageTexture | None = None
        self._start: Net | None = None  # of the present drag
        self._frame: mesh_edit.Frame | None = None
        self._held: dict[str, Any] = {}
        self._begin = 0.0, 0.0
        self._far = 0.0

    @property
    def dragging(self) -> bool:
        """Whether the mouse holds something."""
        return self._start is not None

    def show_field(self, field: Field) -> None:
        """What is shown as edges from now on."""
        high = field.height / max(float(field.height.max()), 1e-9)
        tint = np.array([0.35, 0.85, 1.0]) * high[..., None] ** 0.8
        if self._field is not None:
            self._field.release()
        self._field = ImageTexture(self._context, (255.0 * tint).clip(0, 255).astype(np.uint8))

    def release(self) -> None:
        """Free the pictures."""
        self._photograph.release()
        if self._field is not None:
            self._field.release()

    def draw(self, table: "Dressing", size: tuple[float, float]) -> None:
        """The view at that size, and the hand in it."""
        with self.canvas.drawn("photograph", size) as canvas:
            shown = self._field if self.edges and self._field is not None else self._photograph
            canvas.picture(shown.glo, self.box)
            # What the hand does comes first, so that what is drawn is what is.
            grip = self._whole(table) if self.hand == "whole" else None
            node, touch = (None, Touch()) if self.hand == "whole" else self._node(table)
            self._meshes(table.net)
            rim = mesh_edit.eye(table.net, table.rest, table.species.surface.eye)
            canvas.line(rim, GLASS, 3.0, 0.4)
            canvas.line(rim, MARK, 1.5, 0.9)
            for held in mesh_edit.anchors(table.net):
                self._anchor(mesh_edit.places(table.net, [held])[0])
            if self.hand == "whole":
                self._frame_lines(mesh_edit.frame(table.net), grip)
            elif node is not None:
                place = mesh_edit.places(table.net, [node])[0]
                if touch.held is not None and self._far > CLICK:
                    canvas.line([place, touch.to], HELD, 1.5)
                canvas.dots(place, INK, 5.5, ring=True)

    def _node(self, table: "Dressing") -> tuple[Node | None, Touch]:
        """Pull or anchor a node; the one that the pointer is on."""
        net = table.net
        for name, nodes, reach in (
            ("border", mesh_edit.border(net, self.parts), 0.7),
            ("inside", mesh_edit.inside(net, self.parts), 0.5),
        ):
            touch = self.canvas.touch(name, mesh_edit.places(net, nodes), reach)
            if touch.over is None:
                continue
            node = nodes[touch.over]
            if touch.began:
                self._grasp(table, node)
            if touch.held is not None:
                self._pull(table, node, touch)
            return node, touch
        return None, Touch()

    def _grasp(self, table: "Dressing", node: Node) -> None:
        place = mesh_edit.places(table.net, [node])[0]
        self._start, self._far = copied(table.net), 0.0
        self._held = mesh_edit.beyond(table.net, place, table.reach)
        self._begin = (imgui.get_mouse_pos().x, imgui.get_mouse_pos().y)

    def _pull(self, table: "Dressing", node: Node, touch: Touch) -> None:
        """The node follows the pointer; let go of without having moved, it was clicked."""
        pointer = imgui.get_mouse_pos()
        off = np.hypot(pointer.x - self._begin[0], pointer.y - self._begin[1])
        self._far = max(self._far, float(off))
        drags = self._far > CLICK
        wants_anchor = self.hand == "anchor" or imgui.get_io().key_shift
        if drags and table.relaxing:
            mesh_edit.tug(table.net, node, touch.to)
        elif drags:
            mesh_edit.pull(table.net, node, touch.to, self._held, table.law, PULLS)
        if not touch.ended:
            return
        self._start = None
        mesh_edit.tug(table.net, node, None)
        if wants_anchor:
            here = mesh_edit.places(table.net, [node])[0]
            lifts = mesh_edit.anchored(table.net, node) and not drags
            place = None if lifts else touch.to if drags else (float(here[0]), float(here[1]))
            table.net = mesh_edit.with_anchor(table.net, node, place)
        if drags and not table.relaxing:
            table.net = mesh_edit.kept(table.net)
        if drags or wants_anchor:
            table.did()

    def _whole(self, table: "Dressing") -> int | None:
        """Move, turn or scale all meshes; the grip that the pointer is on."""
        canvas = self.canvas
        shown = (
            self._frame if self._start is not None and self._frame else mesh_edit.frame(table.net)
        )
        grips = np.concatenate([shown.corners, shown.sides, shown.knob[None], shown.middle[None]])
        touch = canvas.touch("grips", grips[:GRIPS], 0.8)
        if touch.over is None:
            moves = canvas.clicked and mesh_edit.within(shown, canvas.mouse)
            touch = canvas.touch("middle", shown.middle, seize=moves)
            touch = touch._replace(
                over=None if touch.over is None else GRIPS,
                held=None if touch.held is None else GRIPS,
            )
        if touch.began:
            self._start, self._frame = copied(table.net), shown
            table.relaxing = False
        if touch.held is None or self._start is None or self._frame is None:
            return touch.over
        begin, to = grips[touch.held], np.array(touch.to)
        table.net = mesh_edit.placed_by(self._start, self._frame, touch.held, begin, to)
        if touch.ended:
            moved = bool(np.abs(to - begin).max() > 0.0)
            self._start = self._frame = None
            if moved:
                table.did()
        return touch.held

    def _meshes(self, net: Net) -> None:
        """Lines of all meshes, and smooth outlines."""
        canvas = self.canvas
        for name, one in meshes(net).items():
            touched = 1.0 if name in self.parts else FAINT
            ink, nodes = INKS[name], one.nodes
            if self.lines:
                for line in (*nodes[1:-1], *nodes.transpose(1, 0, 2)[1:-1]):
                    canvas.line(line, ink, 1.0, 0.32 * touched)
            fine = finer(nodes)
            if name == BODY:
                outline = np.concatenate(
                    [fine[0], fine[1:, -1], fine[-1, -2::-1], fine[-2:0:-1, 0]]
                )
                canvas.line(outline, GLASS, 4.0, 0.35 * touched, closed=True)
                canvas.line(outline, ink, 2.0, 0.95 * touched, closed=True)
            else:
                canvas.line(fine[-1], GLASS, 4.0, 0.35 * touched)
                canvas.line(fine[-1], ink, 2.0, 0.95 * touched)
        canvas.dots(mesh_edit.places(net, mesh_edit.border(net, self.parts)), INK, 2.6, 0.95)

    def _anchor(self, place: Array) -> None:
        self.canvas.dots(place, GLASS, 6.5, 0.8)
        self.canvas.dots(place, HELD, 5.0)

    def _frame_lines(self, shown: mesh_edit.Frame, grip: int | None) -> None:
        canvas = self.canvas
        canvas.line(shown.corners, INK, 1.2, 0.8, closed=True)
        canvas.line([shown.sides[0], shown.knob], INK, 1.2, 0.8)
        grips = np.concatenate([shown.corners, shown.sides, shown.knob[None]])
        canvas.dots(grips[:8], INK, 4.5)
        canvas.dots(shown.knob, MARK, 6.0)
        if grip is not None and grip < GRIPS:
            canvas.dots(grips[grip], MARK, 8.5, ring=True)
