"""The side and the top view of a fish: outline and scaffold, with points to drag.

Both keep the same scale and place along the body. The nodes of a ring have the same colour in both,
and a point in one view is highlighted in the other (KS I.B). A photograph may lie behind the side
view, to trace its outline.
"""

from pathlib import Path
from typing import Any

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from subsea.base.arrays import Array
from subsea.base.system import require
from subsea.biomechanics.body import KINDS, MUSCLES, UNITS, rest_nodes
from subsea.biomechanics.body_plan import NODES_AT_STATION
from subsea.fish.sheet_layout import BODY, borders, half_height
from subsea.fish.species import Species
from subsea.fish.surface import PaddlePlan, along, points_along
from subsea.rendering.gl.textures import ImageTexture
from subsea.studio.draft import EditState, KeyPath, SpeciesDraft
from subsea.studio.handles import Box, DragHandle, View, drag_handle, handles
from subsea.studio.outline import add_point, nearest_line
from subsea.studio.viewport2d import Viewport2D
from subsea.ui.gui import INK, MARK, QUIET, Rgb

FIELD = 7.0  # width of an input, text heights


class PhotoOverlay:
    """A photograph and its place, in body lengths of the side view."""

    def __init__(self, context: Any, pixels: NDArray[Any]) -> None:
        """Take pixels (h, w, 3), top row first; at first as wide as the fish is long."""
        self.shown = ImageTexture(context, pixels)
        self.high = pixels.shape[0] / pixels.shape[1]  # height over width
        self.left, self.middle, self.wide = 0.0, 0.0, 1.0
        self.flipped = False

    @property
    def box(self) -> Box:
        """Left, low, right, high; left and right are swapped if it is flipped."""
        half = 0.5 * self.wide * self.high
        left, right = self.left, self.left + self.wide
        if self.flipped:
            left, right = right, left
        return left, self.middle - half, right, self.middle + half

    def draw_options(self) -> None:
        """Draw a button that opens the options of its place."""
        if imgui.button("Photograph"):
            imgui.open_popup("##photograph")
        if imgui.begin_popup("##photograph"):
            for name in ("left", "middle", "wide"):
                imgui.set_next_item_width(FIELD * imgui.get_font_size())
                low, high = (0.1, 20.0) if name == "wide" else (-10.0, 10.0)
                now = getattr(self, name)
                _, now = imgui.drag_float(f"{name}, lengths", now, 0.002, low, high, "%.3f")
                setattr(self, name, now)
            _, self.flipped = imgui.checkbox("the fish heads right", self.flipped)
            imgui.end_popup()

    def release(self) -> None:
        """Free the texture."""
        self.shown.release()


def read_photo(path: Path) -> NDArray[Any]:
    """Return the pixels of a photograph; UserError for another file, or without OpenCV."""
    require("skin", "the photograph")
    from subsea.studio.photograph import read_photograph

    return read_photograph(path).colour


BOX = -0.05, -0.3, 1.06, 0.3  # of both views at first, body lengths
RINGS: tuple[Rgb, ...] = (
    (1.0, 0.45, 0.42), (1.0, 0.72, 0.30), (0.62, 0.86, 0.36), (0.35, 0.80, 0.95),
    (0.72, 0.58, 1.0), (1.0, 0.58, 0.86),
)  # fmt: skip
SLACK, TIGHT = (0.75, 0.45, 0.42), (1.0, 0.16, 0.10)  # muscles
FULL = 0.35  # contraction that is drawn as tight
BODY_INK, FIN_INK = (0.55, 0.72, 0.80), (0.45, 0.62, 0.72)


class OutlineViews:
    """Both views, and the editing of points in them."""

    def __init__(self) -> None:
        self.side, self.top = Viewport2D(BOX, up=True), Viewport2D(BOX, up=True)
        self.outline, self.scaffold = True, True  # shown, and can be dragged
        self.soft = False  # neighbours follow a dragged point
        self.adding = False  # the next click adds a point
        self._leads: Viewport2D = self.side
        self._drawn_of: SpeciesDraft | None = None
        self._shapes: dict[str, Array] = {}

    @property
    def view(self) -> View:
        """The view that was used last."""
        return "side" if self._leads is self.side else "top"

    def fit(self) -> None:
        """Show the whole fish in both views, at their common scale."""
        self._leads = self.side
        points = np.concatenate([*self._shapes.values(), np.array(BOX).reshape(2, 2)])
        left, right = points[:, 0].min(), points[:, 0].max()
        tall = {
            view: max(np.abs(p[:, 1]).max() for n, p in self._shapes.items() if n.startswith(view))
            for view in ("side", "top")
        }
        # The lower of the two panels may hold the taller view.
        half = max(tall["side"], tall["top"] * self.side.size[1] / self.top.size[1], BOX[3])
        for canvas in (self.side, self.top):
            canvas.fit((float(left), -float(half), float(right), float(half)))

    def draw(
        self, view: View, editing: EditState, size: tuple[float, float], contraction: Array,
        backdrop: tuple[int, Box] | None,
    ) -> None:  # fmt: skip
        """Draw a view; `contraction` (12,) of the muscles, `backdrop` a texture and its place."""
        canvas = self.side if view == "side" else self.top
        other = self.top if view == "side" else self.side
        if canvas is not self._leads:
            canvas.follow(other)
        draft = editing.present
        with canvas.drawn(view, size):
            if canvas.hovered:
                self._leads = canvas
            canvas.grid()
            if backdrop:
                canvas.picture(*backdrop, alpha=0.85 if self.outline else 0.5)
            self._draw_shape(canvas, view, draft)
            if self.scaffold and draft.species.body:
                _draw_scaffold(canvas, view, draft.species, contraction)
            points = [handle for handle in handles(draft, view) if self._shown(handle)]
            _draw_points(canvas, points, editing)
            self._draw_crosshair(canvas, view, editing)
            self._edit_points(canvas, view, editing, points)
            canvas.caption("Side view" if view == "side" else "Top view")

    def _shown(self, handle: DragHandle) -> bool:
        return self.scaffold if handle.path[0] == "body" else self.outline

    def _draw_shape(self, canvas: Viewport2D, view: View, draft: SpeciesDraft) -> None:
        if draft is not self._drawn_of:
            self._drawn_of, self._shapes = draft, outlines(draft.species)
        for name, points in self._shapes.items():
            if name.startswith(view):
                fin = "fin" in name
                if fin:
                    canvas.polygon(points, FIN_INK, 0.16)
                ink = FIN_INK if fin else BODY_INK
                canvas.line(points, ink, 1.2 if fin else 1.6, 0.9 if self.outline else 0.4, True)

    def _draw_crosshair(self, canvas: Viewport2D, view: View, editing: EditState) -> None:
        """Draw a line through both views at the hovered or else the selected point."""
        path, draft = editing.hovered or editing.selected, editing.present
        if path is None or (x := place_of(draft, path)) is None:
            return
        canvas.line([(x, -2.0), (x, 2.0)], MARK, 1.0, 0.45)
        if path[0] == "surface":
            surface = draft.species.surface
            curves = (surface.back, surface.belly) if view == "side" else (surface.width,) * 2
            first, second = (along(curve, np.array([x]))[0] for curve in curves)
            second *= 1.0 if view == "side" else -1.0
            canvas.dots([(x, first), (x, second)], MARK, 4.0, ring=True)

    def _edit_points(
        self, canvas: Viewport2D, view: View, editing: EditState, points: list[DragHandle]
    ) -> None:
        if canvas.clicked:
            reach = 0.8 * imgui.get_font_size() / canvas.scale
            twice = imgui.is_mouse_double_clicked(0)
            near = twice and nearest_line(editing.present, view, canvas.mouse)[1] < reach
            if self.adding or near:
                self._add(canvas, view, editing)
                return
        mirrored = [handle for handle in points if handle.mirrored]
        places = [handle.at for handle in points] + [(x, -y) for (x, y) in (m.at for m in mirrored)]
        drag = canvas.drag_points(view, places)
        if canvas.hovered or drag.dragged is not None:
            editing.hovered = None
        if drag.hovered is None:
            if canvas.clicked:
                editing.selected = None
            return
        path = [*points, *mirrored][drag.hovered].path
        editing.hovered = path
        if drag.dragged is not None:
            editing.selected = path
            editing.drag(lambda draft: drag_handle(draft, view, path, drag.to, self.soft))
            if drag.ended:
                editing.commit()

    def _add(self, canvas: Viewport2D, view: View, editing: EditState) -> None:
        canvas.clicked = self.adding = False

        def edit(draft: SpeciesDraft) -> SpeciesDraft:
            after, editing.selected = add_point(draft, view, canvas.mouse)
            return after

        editing.do(edit)


def outlines(species: Species) -> dict[str, Array]:
    """Return closed lines (n, 2) in body lengths, by view and part, such as "side body"."""
    surface = species.surface
    begin = surface.tail.begin
    x = np.concatenate([np.linspace(0.0, 0.1, 12), np.linspace(0.115, begin, 40)])
    shares, eye = np.linspace(1.0, -1.0, 25), surface.eye
    middle_eye = np.array([eye.at, 0.0 if surface.wing else eye.height])
    angle = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    edge = surface.tail.edge_at(shares)
    top, low = np.linspace(begin, edge[0], 12), np.linspace(begin, edge[-1], 12)
    tip, base = along(surface.back, top), along(surface.belly, low)
    middle, radius = (tip[-1] + base[-1]) / 2, (tip[-1] - base[-1]) / 2
    shapes = {
        "side body": _closed(
            [x, top, edge, low[::-1], x[::-1]],
            [along(surface.back, x), tip, middle + shares * radius, base[::-1],
             along(surface.belly, x)[::-1]],
        ),
        "side eye": middle_eye + eye.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1),
    }  # fmt: skip
    for name, plan, ridge in (
        ("dorsal", surface.dorsal, surface.back),
        ("ventral", surface.ventral, surface.belly),
    ):
        if plan:
            free = points_along(plan.edge, np.linspace(0.0, 1.0, 40))
            root = np.linspace(*plan.base, 20)
            heights = [free[:, 1], along(ridge, root)[::-1]]
            shapes[f"side {name} fin"] = _closed([free[:, 0], root[::-1]], heights)
    for name, paddle in (("pectoral", surface.pectoral), ("pelvic", surface.pelvic)):
        if paddle:
            shapes[f"side {name} fin"] = _paddle(paddle)
    whole = np.concatenate([x, np.linspace(begin, 1.0, 12)[1:]])
    wide = along(surface.width, whole)
    shapes["top body"] = _closed([whole, whole[::-1]], [wide, -wide[::-1]])
    if surface.wing:
        wing = np.array(surface.wing.outline)
        shapes["top wing"] = _closed([wing[:, 0], wing[::-1, 0]], [wing[:, 1], -wing[::-1, 1]])
    return shapes


def _closed(x: list[Array], y: list[Array]) -> Array:
    return np.stack([np.concatenate(x), np.concatenate(y)], axis=1)


def _paddle(plan: PaddlePlan) -> Array:
    """Return a paired fin laid flat on the flank, about as `fish.mesh` has it."""
    out, side = np.linspace(0.0, 1.0, 14), np.linspace(1.0, -1.0, 9)
    half = 0.5 * plan.width * (0.25 + 0.75 * np.sin(0.76 * np.pi * out))
    edge = out - 0.3 * out**2
    way = np.concatenate([edge, 1.0 - 0.3 * side[1:-1] ** 2, edge[::-1]])
    across = np.concatenate([half, half[-1] * side[1:-1], -half[::-1]])
    droop = np.radians(plan.droop)
    tail, up = np.array([np.cos(droop), -np.sin(droop)]), np.array([np.sin(droop), np.cos(droop)])
    root = np.array([plan.at, plan.height])
    return np.asarray(root + np.outer(plan.length * way, tail) + np.outer(across, up))


def place_of(draft: SpeciesDraft, path: KeyPath) -> float | None:
    """Return the distance of a point from the snout; None if it does not exist."""
    views: tuple[View, ...] = ("side", "top")
    points = (handle for view in views for handle in handles(draft, view))
    return next((point.at[0] for point in points if point.path == path), None)


def scaffold(view: View, species: Species) -> Array:
    """Return the nodes (23, 2) in a view, body lengths."""
    assert species.body
    nodes = rest_nodes(species.body)
    across = nodes[:, 1 if view == "side" else 2]
    return np.stack([species.body.stations[2] - nodes[:, 0], across], axis=1) / species.body.length


def _draw_scaffold(canvas: Viewport2D, view: View, species: Species, contraction: Array) -> None:
    """Draw units, red where muscles contract, and nodes in the colours of their rings."""
    nodes = scaffold(view, species)
    for number, (i, j) in enumerate(UNITS):
        pair = nodes[[i, j]]
        if number < MUSCLES:
            share = float(np.clip(contraction[number] / FULL, 0.0, 1.0))
            red, green, blue = (a + share * (b - a) for a, b in zip(SLACK, TIGHT, strict=True))
            canvas.line(pair, (red, green, blue), 2.0 + 2.0 * share, 0.9)
        else:
            canvas.line(pair, QUIET, 1.0, 0.10 if KINDS[number] == 1 else 0.38)
    assert species.body
    station = np.repeat(np.arange(7), NODES_AT_STATION)
    masses = np.array(species.body.masses)
    radius = 2.5 + 3.0 * np.cbrt(masses / masses[1:].mean())  # the heavier the larger
    for number in range(1, 7):
        canvas.dots(nodes[station == number], RINGS[number - 1], radius[number])
    canvas.dots(nodes[:1], INK, 3.0)


def _draw_points(canvas: Viewport2D, points: list[DragHandle], editing: EditState) -> None:
    """Draw the points; mark the selected and the hovered one."""
    plain = [handle for handle in points if handle.path[0] != "body"]
    for handle in plain:
        special = handle.path[-1] in ("begin", "at", "length") or handle.path[2:3] == ("base",)
        canvas.dots(_twins(handle), FIN_INK if special else INK, 3.2, 0.95)
    for path, radius in ((editing.selected, 7.0), (editing.hovered, 6.0)):
        for handle in points:
            if handle.path == path:
                canvas.dots(_twins(handle), MARK, radius, ring=True)


def _twins(handle: DragHandle) -> list[tuple[float, float]]:
    """Return the place of a point, and its mirror image if it has one."""
    return [handle.at, (handle.at[0], -handle.at[1])] if handle.mirrored else [handle.at]


def textured_view(species: Species, sheet: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], Box]:
    """Return the sheet cut out along the outline, for the side view or that of a ray from above.

    Pixels (h, w, 4), top row first; box in body lengths.
    """
    surface = species.surface
    rows, columns = sheet.shape[0], sheet.shape[1]
    body = sheet[: round(BODY.top * rows)]
    top, (front, rear) = half_height(surface), borders(surface)
    if surface.wing:
        upper = body[len(body) // 2 :]  # from the tips inward; its last row lies on the spine
        body = np.concatenate([upper, upper[::-1]])
        # Half of the unfolded sheet is as high as all of this picture's half.
        shape = outlines(species)["top wing"]
    else:
        shape = outlines(species)["side body"]
    height = len(body)
    mask = Image.new("L", (columns, height), 0)
    across = (shape[:, 0] - front) / (rear - front) * columns
    up = (shape[:, 1] + top) / (2 * top) * height
    ImageDraw.Draw(mask).polygon(list(zip(across.tolist(), up.tolist(), strict=True)), fill=255)
    out = body.copy()
    out[..., 3] = np.minimum(out[..., 3], np.asarray(mask))
    return np.ascontiguousarray(out[::-1]), (front, -top, rear, top)
