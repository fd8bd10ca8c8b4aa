"""The side view and the top view of a fish: outline and scaffold, and hands that move their points.

Both have the same scale and the same place along the body. The nodes of a ring have the same colour
in both, and what a point in one view stands for is lit in the other (KS I.B).
"""

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from subsea.biomechanics.body import KINDS, MUSCLES, UNITS, rest_nodes
from subsea.biomechanics.body_plan import NODES_AT_STATION
from subsea.core.arrays import Array
from subsea.fish.editing import draft as drafts
from subsea.fish.editing.draft import Draft, Path_, Spot, View
from subsea.fish.editing.edit_state import Editing
from subsea.fish.paint import BODY, borders, half_height
from subsea.fish.species import Species
from subsea.fish.surface import PaddlePlan, along, travelled
from subsea.ui.gui import INK, MARK, QUIET
from subsea.ui.viewport2d import Canvas

Ink = tuple[float, float, float]

BOX = -0.05, -0.3, 1.06, 0.3  # that both views show at first, body lengths
RINGS: tuple[Ink, ...] = (
    (1.0, 0.45, 0.42), (1.0, 0.72, 0.30), (0.62, 0.86, 0.36), (0.35, 0.80, 0.95),
    (0.72, 0.58, 1.0), (1.0, 0.58, 0.86),
)  # fmt: skip
SLACK, TIGHT = (0.75, 0.45, 0.42), (1.0, 0.16, 0.10)  # muscles
FULL = 0.35  # contraction at which a muscle is drawn as tight
BODY_INK, FIN_INK = (0.55, 0.72, 0.80), (0.45, 0.62, 0.72)


class Views:
    """Both views, and what hands do in them."""

    def __init__(self) -> None:
        """The fish as large as fits; nothing is hidden."""
        self.side, self.top = Canvas(BOX, up=True), Canvas(BOX, up=True)
        self.outline, self.scaffold = True, True  # whether they are shown, and can be taken hold of
        self.soft = False  # whether the neighbours of a point go along with it
        self.adding = False  # whether the next click adds a point
        self._leads: Canvas = self.side
        self._drawn_of: Draft | None = None
        self._shapes: dict[str, Array] = {}

    @property
    def view(self) -> View:
        """The view that was touched last."""
        return "side" if self._leads is self.side else "top"

    def fit(self) -> None:
        """The whole fish again."""
        self._leads = self.side
        self.side.fit()

    def draw(
        self, view: View, editing: Editing, size: tuple[float, float], contraction: Array,
        dressed: tuple[int, drafts.Box] | None,
    ) -> None:  # fmt: skip
        """A view; `contraction` (12,) of the muscles, `dressed` a texture and its place."""
        canvas = self.side if view == "side" else self.top
        other = self.top if view == "side" else self.side
        if canvas is not self._leads:
            canvas.follow(other)
        draft = editing.present
        with canvas.drawn(view, size):
            if canvas.hovered:
                self._leads = canvas
            canvas.grid()
            if dressed:
                canvas.picture(*dressed, alpha=0.85 if self.outline else 0.5)
            self._draw_shape(canvas, view, draft)
            if self.scaffold and draft.species.body:
                _draw_scaffold(canvas, view, draft.species, contraction)
            spots = [spot for spot in drafts.spots(draft, view) if self._shown(spot)]
            _draw_spots(canvas, spots, editing)
            self._hair(canvas, view, editing)
            self._hands(canvas, view, editing, spots)
            canvas.caption("Side view" if view == "side" else "Top view")

    def _shown(self, spot: Spot) -> bool:
        return self.scaffold if spot.path[0] == "body" else self.outline

    def _draw_shape(self, canvas: Canvas, view: View, draft: Draft) -> None:
        if draft is not self._drawn_of:
            self._drawn_of, self._shapes = draft, outlines(draft.species)
        for name, points in self._shapes.items():
            if name.startswith(view):
                fin = "fin" in name
                if fin:
                    canvas.area(points, FIN_INK, 0.16)
                ink = FIN_INK if fin else BODY_INK
                canvas.line(points, ink, 1.2 if fin else 1.6, 0.9 if self.outline else 0.4, True)

    def _hair(self, canvas: Canvas, view: View, editing: Editing) -> None:
        """A line through both views at what is pointed at, or else chosen."""
        path = editing.over or editing.chosen
        if path is None:
            return
        draft = editing.present
        x = place_of(draft, path)
        if x is None:
            return
        canvas.line([(x, -2.0), (x, 2.0)], MARK, 1.0, 0.45)
        if path[0] == "surface":
            surface, at = draft.species.surface, np.array([x])
            values = (
                (along(surface.back, at)[0], along(surface.belly, at)[0])
                if view == "side"
                else (along(surface.width, at)[0], -along(surface.width, at)[0])
            )
            canvas.dots([(x, y) for y in values], MARK, 4.0, ring=True)

    def _hands(self, canvas: Canvas, view: View, editing: Editing, spots: list[Spot]) -> None:
        """Points are dragged, added and chosen."""
        twice = canvas.clicked and imgui.is_mouse_double_clicked(0)
        if canvas.clicked and (self.adding or (twice and self._near_line(canvas, view, editing))):
            self._add(canvas, view, editing)
            return
        mirrored = [spot for spot in spots if spot.mirror]
        places = [spot.at for spot in spots] + [(x, -y) for (x, y) in (m.at for m in mirrored)]
        touch = canvas.touch(view, places)
        if canvas.hovered or touch.held is not None:
            editing.over = None
        if touch.over is None:
            if canvas.clicked:
                editing.chosen = None
            return
        path = [*spots, *mirrored][touch.over].path
        editing.over = path
        if touch.held is not None:
            editing.chosen = path
            editing.hold(lambda draft: drafts.moved(draft, view, path, touch.to, self.soft))
            if touch.ended:
                editing.settle()

    def _near_line(self, canvas: Canvas, view: View, editing: Editing) -> bool:
        reach = 0.8 * imgui.get_font_size() / canvas.scale
        return drafts.nearest_line(editing.present, view, canvas.mouse)[1] < reach

    def _add(self, canvas: Canvas, view: View, editing: Editing) -> None:
        canvas.clicked = self.adding = False

        def edit(draft: Draft) -> Draft:
            after, editing.chosen = drafts.added(draft, view, canvas.mouse)
            return after

        editing.do(edit)


def outlines(species: Species) -> dict[str, Array]:
    """Closed lines (n, 2) of each view in body lengths, by the view and what they are of."""
    surface = species.surface
    begin = surface.tail.begin
    x = np.concatenate([np.linspace(0.0, 0.1, 12), np.linspace(0.115, begin, 40)])
    shares = np.linspace(1.0, -1.0, 25)
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
        "side eye": _round(surface.eye.at, 0.0 if surface.wing else surface.eye.height,
                           surface.eye.radius),
    }  # fmt: skip
    for name, plan, ridge in (
        ("dorsal", surface.dorsal, surface.back),
        ("ventral", surface.ventral, surface.belly),
    ):
        if plan:
            free, root = (
                travelled(plan.edge, np.linspace(0.0, 1.0, 40)),
                np.linspace(*plan.base, 20),
            )
            shapes[f"side {name} fin"] = _closed(
                [free[:, 0], root[::-1]], [free[:, 1], along(ridge, root)[::-1]]
            )
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


def _round(x: float, y: float, radius: float) -> Array:
    angle = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    return np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=1)


def _paddle(plan: PaddlePlan) -> Array:
    """A paired fin as if it lay on the flank; about as `skins.mesh` has it."""
    out, side = np.linspace(0.0, 1.0, 14), np.linspace(1.0, -1.0, 9)
    half = 0.5 * plan.width * (0.25 + 0.75 * np.sin(0.76 * np.pi * out))
    edge = out - 0.3 * out**2
    way = np.concatenate([edge, 1.0 - 0.3 * side[1:-1] ** 2, edge[::-1]])
    across = np.concatenate([half, half[-1] * side[1:-1], -half[::-1]])
    droop = np.radians(plan.droop)
    tail, up = np.array([np.cos(droop), -np.sin(droop)]), np.array([np.sin(droop), np.cos(droop)])
    root = np.array([plan.at, plan.height])
    return np.asarray(root + np.outer(plan.length * way, tail) + np.outer(across, up))


def place_of(draft: Draft, path: Path_) -> float | None:
    """How far behind the snout a point is; None where it is no more."""
    for view in ("side", "top"):
        for spot in drafts.spots(draft, view):
            if spot.path == path:
                return spot.at[0]
    return None


def scaffold(view: View, species: Species) -> Array:
    """The nodes (23, 2) of a view, body lengths."""
    assert species.body
    nodes = rest_nodes(species.body)
    across = nodes[:, 1 if view == "side" else 2]
    return np.stack([species.body.stations[2] - nodes[:, 0], across], axis=1) / species.body.length


def _draw_scaffold(canvas: Canvas, view: View, species: Species, contraction: Array) -> None:
    """Units, the muscles as red as they are contracted, and nodes in the colours of their rings."""
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


def _draw_spots(canvas: Canvas, spots: list[Spot], editing: Editing) -> None:
    """Points that can be dragged; the one that is chosen, and the one that is pointed at."""
    plain = [spot for spot in spots if spot.path[0] != "body"]
    for spot in plain:
        twins = [spot.at, (spot.at[0], -spot.at[1])] if spot.mirror else [spot.at]
        special = spot.path[-1] in ("begin", "at", "length") or spot.path[2:3] == ("base",)
        canvas.dots(twins, FIN_INK if special else INK, 3.2, 0.95)
    for path, radius in ((editing.chosen, 7.0), (editing.over, 6.0)):
        for spot in spots:
            if spot.path == path:
                twins = [spot.at, (spot.at[0], -spot.at[1])] if spot.mirror else [spot.at]
                canvas.dots(twins, MARK, radius, ring=True)


def dressed(species: Species, sheet: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], drafts.Box]:
    """The fish from the side, of a flat one from above, as its sheet has it: pixels and place.

    (h, w, 4), top row first, clear outside of the outline; left, low, right, high in body lengths.
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
