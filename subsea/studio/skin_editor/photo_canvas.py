"""The photograph with the meshes over it, edited by the mouse."""

from typing import Any, Literal

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from subsea.rendering.gl.textures import ImageTexture
from subsea.studio import mesh_edit
from subsea.studio.deformable_mesh import BODY, DORSAL, VENTRAL, EdgeField, FishMeshes, copy_meshes
from subsea.studio.mesh_edit import MeshNode
from subsea.studio.side_view import outline, subdivide
from subsea.studio.skin_editor.document import SkinDocument
from subsea.studio.viewport2d import PointDrag, Viewport2D
from subsea.ui.gui import GLASS, INK, MARK

Mode = Literal["pull", "anchor", "whole"]

MODES: dict[Mode, tuple[str, str]] = {
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
ANCHOR_INK = (1.0, 0.45, 0.25)  # also of the spring of the mouse
FAINT = 0.35  # alpha of parts that cannot be edited
GRIPS = 9  # of the transform box: corners, sides, knob
PULL_STEPS = 40  # of the springs in a frame, while a node is dragged
CLICK = 3.0  # pointer units: a shorter drag is a click


def same_line(label: str, gap: float = 0.0) -> None:
    """Put the next widget beside the last, if there is room for its label."""
    line = imgui.get_font_size()
    imgui.same_line(0.0, imgui.get_style().item_spacing.x + gap * line)
    if imgui.get_content_region_avail().x < imgui.calc_text_size(label).x + 2.0 * line:
        imgui.new_line()


class PhotoCanvas:
    """The view of the photograph, its options, and the drag in progress."""

    def __init__(self, context: Any, colour: NDArray[np.uint8], shape: tuple[int, ...]) -> None:
        """Show a photograph (h, w, 3) in the coordinates of a picture of `shape`."""
        self._context = context
        height, width = shape[:2]
        self.box = -0.5, -0.5, width - 0.5, height - 0.5  # pixel centres are whole numbers
        self.view = Viewport2D(self.box)
        self.mode: Mode = "pull"
        self.parts: tuple[str, ...] = (BODY, DORSAL, VENTRAL)  # that can be edited
        self.edges = False  # show edges instead of the photograph
        self.lines = True  # draw inner lines of meshes
        self._photograph = ImageTexture(context, colour)
        self._field: EdgeField | None = None  # whose texture this is:
        self._field_texture: ImageTexture | None = None
        self._start: FishMeshes | None = None  # of the present drag
        self._box: mesh_edit.TransformBox | None = None
        self._held: dict[str, Any] = {}
        self._begin = 0.0, 0.0
        self._distance = 0.0

    @property
    def dragging(self) -> bool:
        """True if a drag is in progress."""
        return self._start is not None

    def _edges(self, field: EdgeField) -> ImageTexture:
        """Return a texture of the edge field."""
        if self._field_texture is not None:
            if field is self._field:
                return self._field_texture
            self._field_texture.release()
        high = field.height / max(float(field.height.max()), 1e-9)
        tint = np.array([0.35, 0.85, 1.0]) * high[..., None] ** 0.8
        pixels = (255.0 * tint).clip(0, 255).astype(np.uint8)
        self._field, self._field_texture = field, ImageTexture(self._context, pixels)
        return self._field_texture

    def release(self) -> None:
        """Free the textures."""
        self._photograph.release()
        if self._field_texture is not None:
            self._field_texture.release()

    def draw(self, document: SkinDocument, size: tuple[float, float]) -> None:
        """Handle the mouse, then draw the view."""
        with self.view.drawn("photograph", size) as view:
            shown = self._edges(document.field) if self.edges else self._photograph
            view.picture(shown.glo, self.box)
            grip = self._drag_box(document) if self.mode == "whole" else None
            node, drag = (None, PointDrag()) if self.mode == "whole" else self._drag_node(document)
            self._draw_meshes(document.meshes)
            rim = mesh_edit.eye_outline(
                document.meshes, document.rest, document.species.surface.eye
            )
            view.line(rim, GLASS, 3.0, 0.4)
            view.line(rim, MARK, 1.5, 0.9)
            anchors = mesh_edit.anchored_nodes(document.meshes)
            for place in mesh_edit.node_places(document.meshes, anchors):
                view.dots(place, GLASS, 6.5, 0.8)
                view.dots(place, ANCHOR_INK, 5.0)
            if self.mode == "whole":
                self._draw_box(mesh_edit.transform_box(document.meshes), grip)
            elif node is not None:
                place = mesh_edit.node_places(document.meshes, [node])[0]
                if drag.dragged is not None and self._distance > CLICK:
                    view.line([place, drag.to], ANCHOR_INK, 1.5)
                view.dots(place, INK, 5.5, ring=True)

    def draw_options(self) -> None:
        """Draw the choice of the mouse mode, and of what is shown."""
        for number, (mode, (label, tip)) in enumerate(MODES.items()):
            if number:
                same_line(label)
            if imgui.radio_button(label, self.mode == mode):
                self.mode = mode
            imgui.set_item_tooltip(tip)
        same_line("Photograph Edges", gap=1.5)
        if imgui.radio_button("Photograph", not self.edges):
            self.edges = False
        same_line("Edges")
        if imgui.radio_button("Edges", self.edges):
            self.edges = True
        same_line("Mesh lines")
        self.lines = imgui.checkbox("Mesh lines", self.lines)[1]
        same_line("Whole picture")
        if imgui.button("Whole picture"):
            self.view.fit()

    def _drag_node(self, document: SkinDocument) -> tuple[MeshNode | None, PointDrag]:
        """Pull or anchor a node; return the one under the pointer."""
        meshes = document.meshes
        for name, nodes, reach in (
            ("border", mesh_edit.border_nodes(meshes, self.parts), 0.7),
            ("inside", mesh_edit.inner_nodes(meshes, self.parts), 0.5),
        ):
            drag = self.view.drag_points(name, mesh_edit.node_places(meshes, nodes), reach)
            if drag.hovered is None:
                continue
            node = nodes[drag.hovered]
            if drag.began:
                self._begin_drag(document, node)
            if drag.dragged is not None:
                self._pull(document, node, drag)
            return node, drag
        return None, PointDrag()

    def _begin_drag(self, document: SkinDocument, node: MeshNode) -> None:
        place = mesh_edit.node_places(document.meshes, [node])[0]
        self._start, self._distance = copy_meshes(document.meshes), 0.0
        self._held = mesh_edit.nodes_beyond(document.meshes, place, document.reach)
        self._begin = (imgui.get_mouse_pos().x, imgui.get_mouse_pos().y)

    def _pull(self, document: SkinDocument, node: MeshNode, drag: PointDrag) -> None:
        """Move the node to the pointer; a drag without motion is a click."""
        pointer = imgui.get_mouse_pos()
        off = np.hypot(pointer.x - self._begin[0], pointer.y - self._begin[1])
        self._distance = max(self._distance, float(off))
        moved = self._distance > CLICK
        wants_anchor = self.mode == "anchor" or imgui.get_io().key_shift
        if moved and document.relaxing:
            mesh_edit.set_mouse_target(document.meshes, node, drag.to)
        elif moved:
            mesh_edit.pull_node(
                document.meshes, node, drag.to, self._held, document.parameters, PULL_STEPS
            )
        if not drag.ended:
            return
        self._start = None
        mesh_edit.set_mouse_target(document.meshes, node, None)
        if wants_anchor:
            here = mesh_edit.node_places(document.meshes, [node])[0]
            lifts = mesh_edit.is_anchored(document.meshes, node) and not moved
            place = None if lifts else drag.to if moved else (float(here[0]), float(here[1]))
            document.meshes = mesh_edit.with_anchor(document.meshes, node, place)
        if moved and not document.relaxing:
            document.meshes = mesh_edit.with_rest_shape(document.meshes)
        if moved or wants_anchor:
            document.record()

    def _drag_box(self, document: SkinDocument) -> int | None:
        """Move, turn or scale all meshes; return the grip under the pointer."""
        view = self.view
        dragged = self._box if self._start is not None else None
        shown = dragged or mesh_edit.transform_box(document.meshes)
        grips = np.concatenate([shown.corners, shown.sides, shown.knob[None], shown.middle[None]])
        drag = view.drag_points("grips", grips[:GRIPS], 0.8)
        if drag.hovered is None:
            moves = view.clicked and mesh_edit.is_inside(shown, view.mouse)
            drag = view.drag_points("middle", shown.middle, anywhere=moves)
            drag = drag._replace(
                hovered=None if drag.hovered is None else GRIPS,
                dragged=None if drag.dragged is None else GRIPS,
            )
        if drag.began:
            self._start, self._box = copy_meshes(document.meshes), shown
            document.relaxing = False
        if drag.dragged is None or self._start is None or self._box is None:
            return drag.hovered
        begin, to = grips[drag.dragged], np.array(drag.to)
        document.meshes = mesh_edit.drag_grip(self._start, self._box, drag.dragged, begin, to)
        if drag.ended:
            moved = bool(np.abs(to - begin).max() > 0.0)
            self._start = self._box = None
            if moved:
                document.record()
        return drag.dragged

    def _draw_meshes(self, meshes: FishMeshes) -> None:
        view = self.view
        for name, mesh in meshes.parts.items():
            alpha = 1.0 if name in self.parts else FAINT
            ink, nodes = INKS[name], mesh.nodes
            if self.lines:
                for line in (*nodes[1:-1], *nodes.transpose(1, 0, 2)[1:-1]):
                    view.line(line, ink, 1.0, 0.32 * alpha)
            closed, fine = name == BODY, subdivide(nodes)
            line = outline(fine) if closed else fine[-1]  # of a fin, its free edge
            view.line(line, GLASS, 4.0, 0.35 * alpha, closed)
            view.line(line, ink, 2.0, 0.95 * alpha, closed)
        border = mesh_edit.border_nodes(meshes, self.parts)
        view.dots(mesh_edit.node_places(meshes, border), INK, 2.6, 0.95)

    def _draw_box(self, shown: mesh_edit.TransformBox, grip: int | None) -> None:
        view = self.view
        view.line(shown.corners, INK, 1.2, 0.8, closed=True)
        view.line([shown.sides[0], shown.knob], INK, 1.2, 0.8)
        grips = np.concatenate([shown.corners, shown.sides, shown.knob[None]])
        view.dots(grips[:8], INK, 4.5)
        view.dots(shown.knob, MARK, 6.0)
        if grip is not None and grip < GRIPS:
            view.dots(grips[grip], MARK, 8.5, ring=True)
