"""Read the warp mesh of a channel from the files of calibration programs.

Every parser takes the bytes of a file, the pixels of its projector and the name of the file for
errors. It returns a `MeasuredMesh`, or raises a UserError of one line. `FORMATS` lists the parsers.
"""

import itertools
import math
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError
from subsea.base.files import MIB, logical_lines, read_input, text_of
from subsea.stage.theatre.measured_mesh import (
    MeasuredMesh,
    ViewAngles,
    node_mesh,
    numbers_of,
    quaternion_rotation,
    strip_triangles,
    turned,
    turns,
)
from subsea.stage.theatre.pixel_files import parse_pfm
from subsea.stage.theatre.vioso import parse_vioso
from subsea.stage.theatre.warp import continued, from_grid, mesh, rasterized, validated
from subsea.view.meshes import grid_triangles
from subsea.view.rig import Warp

Size = tuple[int, int]
MAX_BYTES = 512 * MIB
MAX_TEXT = 64 * MIB  # of numbers as text, which take many times the memory
BINARY = ".pfm", ".sgc", ".vwf"
MAX_NODES = 2**24  # of a grid whose size a file states
MASK_SIDE = 512  # pixels of the longer side of a mask: brightness is smooth


def read_warp(path: Path, size: Size) -> tuple[Warp, NDArray[np.float32] | None]:
    """Read the warp for a projector of `size` pixels, and the mask (h, w, 4) if there is one."""
    measured = read_mesh(path, size)
    return measured.warp, measured.mask


def read_mesh(path: Path, size: Size) -> MeasuredMesh:
    """Read all that a warp file says, with the view in a file beside it.

    The suffix tells the format (`FORMATS`).
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise UserError(f"expected a warp file that ends in {', '.join(FORMATS)}", file=path)
    most = MAX_BYTES if suffix in BINARY else MAX_TEXT
    measured = FORMATS[suffix](read_input(path, most), size, str(path))
    beside = path.with_name(f"{path.stem.removesuffix('_mesh')}_frustum.csv")
    if suffix == ".csv" and beside.is_file():
        measured = measured._replace(view=parse_frustum(read_input(beside), str(beside)))
    return measured


def text_rows(
    data: bytes, where: str, separator: str | None = None
) -> Iterator[tuple[int, list[str]]]:
    """Split text into the number and words of each line, without comments after ``#``.

    Lines that end in a backslash go on in the next one. Comments may be Latin-1.
    """
    text = text_of(data, where, foreign=True)
    if "\0" in text:
        raise UserError("not text, expected lines of words and numbers", file=where)
    for number, line in logical_lines(text):
        if plain := line.partition("#")[0].strip():
            yield number, [word.strip() for word in plain.split(separator)]


def parse_xml(data: bytes, where: str) -> ElementTree.Element:
    """Parse a document; names of elements and attributes become lower case."""
    try:
        try:
            root = ElementTree.fromstring(data)
        except ElementTree.ParseError:  # perhaps Latin-1, which is not declared
            root = ElementTree.fromstring(text_of(data, where, foreign=True))
    except (ElementTree.ParseError, LookupError, ValueError) as fault:
        raise UserError(f"not readable XML ({fault})", file=where) from fault
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2].lower()  # without a namespace
        element.attrib = {key.lower(): value for key, value in element.attrib.items()}
    return root


def check_grid(columns: float, rows: float, where: str) -> None:
    """Refuse a grid of fewer than 2×2 nodes or of more than MAX_NODES."""
    if not (min(columns, rows) >= 2 and columns * rows <= MAX_NODES):
        raise UserError(
            f"{columns:g}×{rows:g} nodes, expected 2×2 to {MAX_NODES} in all", file=where
        )


def regular_sources(columns: int, rows: int) -> Array:
    """Place nodes (n, 2) on a grid from edge to edge, row after row from the upper left."""
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(1, 0, rows))
    return np.column_stack([u.ravel(), v.ravel()])


def sources_of(numbers: NDArray[np.float32], where: str) -> NDArray[np.float32]:
    """Take u and v (h, w, 2) from the numbers (h, w, c) of a PFM file; UserError for a grey one."""
    height, width, count = numbers.shape
    if count != 3:
        raise UserError("one number a point ('Pf'), expected u and v ('PF')", file=where)
    if min(height, width) < 2:
        raise UserError(f"{width}×{height} points, expected 2×2 or more", file=where)
    return numbers[..., :2]


def _brightness_mask(shown: Warp, light: Array, size: Size) -> NDArray[np.float32]:
    """Make a mask (h, w, 4) from the brightness (n,) of nodes, for a projector of `size`."""
    width, height = (max(round(MASK_SIDE * side / max(size)), 1) for side in size)
    mask = np.zeros((height, width, 4), np.float32)
    lit = rasterized(shown, np.ones(len(light)), (width, height)) > 0
    mask[..., :3] = continued(rasterized(shown, light, (width, height))[..., None], lit).clip(0, 1)
    return mask


def _parse_pfm(data: bytes, size: Size, where: str) -> MeasuredMesh:
    sources = sources_of(parse_pfm(data, where), where)
    return MeasuredMesh(validated(from_grid(sources, size), where))


# Other statements of OBJ files: normals, groups, smoothing, lines, materials, curves, surfaces.
OBJ_IGNORED = {
    "vn", "vp", "g", "o", "s", "l", "p", "mtllib", "usemtl", "mg", "lod", "bevel", "c_interp",
    "d_interp", "shadow_obj", "trace_obj", "ctech", "stech", "maplib", "usemap", "cstype", "deg",
    "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp", "end", "con",
    "call", "csh",
}  # fmt: skip


def parse_obj(data: bytes, _: Size, where: str) -> MeasuredMesh:
    """Parse a Wavefront OBJ file.

    ``v x y z`` is a point on the projector, ``vt u v`` one of the picture that is shown, ``f`` a
    polygon of both. As in SGCT (src/sgct/correction/obj.cpp) and in Sparck's MeshWarp, x and y run
    from -1 on the left and below to 1; a mesh with neither x nor y below -0.5 is taken as one from
    0 to 1, as other tools write it. z is ignored. u and v run from 0, on the left and below, to 1.
    """
    return MeasuredMesh(validated(obj_mesh(data, where), where))


def obj_mesh(data: bytes, where: str, signed: bool = False) -> Warp:
    """Read the mesh of an OBJ file without validating it.

    `signed`: x and y are from -1 to 1, whatever they are.
    """
    points: list[list[float]] = []
    shown: list[list[float]] = []
    corners: list[tuple[int, int]] = []  # of all faces: indices of a point and its source
    triangles: list[tuple[int, int, int]] = []  # indices of corners
    for number, (kind, *words) in text_rows(data, where):
        at = f"{where}: line {number}"
        if kind == "v":
            points.append(numbers_of(words, 2, at, "x y"))
        elif kind == "vt":
            shown.append(numbers_of(words, 2, at, "u v"))
        elif kind == "f":
            first = len(corners)
            corners.extend(_obj_corner(word, len(points), len(shown), at) for word in words)
            if len(words) < 3:
                raise UserError(f"{at}: a face of {len(words)} corners, expected 3 or more")
            others = range(first + 1, len(corners))
            triangles.extend((first, i, j) for i, j in itertools.pairwise(others))
        elif kind not in OBJ_IGNORED:
            raise UserError(f"{at}: {kind[:20]!r} is not a keyword of OBJ files")
    if not triangles:
        raise UserError("an empty mesh, expected 'v', 'vt' and 'f' lines", file=where)
    used, numbers = np.unique(np.array(corners), axis=0, return_inverse=True)
    places = np.array(points)[used[:, 0]]
    if signed or places.min() < -0.5:
        places = (places + 1) / 2
    faces = numbers.reshape(-1)[np.array(triangles)]
    return mesh(places, np.array(shown)[used[:, 1]], faces)


def _obj_corner(word: str, points: int, shown: int, at: str) -> tuple[int, int]:
    """Read the indices, from 0, of a corner such as 3/5 or -1/-1/2; 3 is 3/3."""
    parts = word.split("/")
    try:
        point = int(parts[0])
        source = int(parts[1]) if len(parts) > 1 and parts[1] else point
    except ValueError as fault:
        raise UserError(f"{at}: corner {word[:40]!r}, expected numbers such as 3/3") from fault
    indices = []
    for index, count, kind in ((point, points, "v"), (source, shown, "vt")):
        index += count + 1 if index < 0 else 0
        if not 1 <= index <= count:
            expected = f"expected one of {count} {kind!r} lines before it"
            raise UserError(f"{at}: corner {word[:40]!r}, {expected}")
        indices.append(index - 1)
    return indices[0], indices[1]


POLAR, RECTANGULAR = 1, 2


def parse_bourke(data: bytes, size: Size, where: str) -> MeasuredMesh:
    """Parse a mesh in the text format of Paul Bourke, as domes with a spherical mirror use.

    The first line is 1 for a polar or 2 for a rectangular mesh, the second its columns and rows;
    then comes a node a line: x y u v and a brightness (paulbourke.net/dataformats/meshwarp). y runs
    from -1 to 1 and x from -a to a, a the aspect ratio of the projector; u and v from 0 to 1; both
    from the lower left. A node of negative brightness is not used. The columns of a polar mesh
    close to a ring.
    """
    lines = list(text_rows(data, where))
    try:
        (kind,), (columns, rows) = ([int(word) for word in words] for _, words in lines[:2])
        if kind not in (POLAR, RECTANGULAR) or min(columns, rows) < 2:
            raise ValueError
    except ValueError as fault:
        raise UserError(
            "expected a line '1' or '2' and a line of columns and rows", file=where
        ) from fault
    if len(lines) - 2 != columns * rows:
        raise UserError(f"expected {columns} times {rows} nodes, got {len(lines) - 2}", file=where)
    names = "x y u v and brightness"
    for number, words in lines[2:]:
        if len(words) != 5:
            raise UserError(f"{where}: line {number}: expected the numbers {names}")
    nodes = [numbers_of(words, 5, f"{where}: line {n}", names) for n, words in lines[2:]]
    x, y, u, v, brightness = np.array(nodes).T
    places = np.stack([(x / (size[0] / size[1]) + 1) / 2, (y + 1) / 2], axis=1)
    edges = columns + (kind == POLAR)  # the last column of a ring is the first again
    row, column = np.divmod(grid_triangles(edges, rows), edges)
    triangles = (row * columns + column % columns).reshape(2, -1, 3)
    triangles = triangles[::-1, :, [0, 2, 1]].reshape(-1, 3)  # counterclockwise
    triangles = triangles[(brightness >= 0)[triangles].all(axis=1)]
    shown = mesh(places, np.stack([u, v], axis=1), triangles)
    warp = validated(shown, where)
    return MeasuredMesh(warp, _brightness_mask(shown, np.clip(brightness, 0.0, 1.0), size))


SGC_HEADER, SGC_NODE = 60, 24  # bytes
SGC_TRIANGLES = 4  # OpenGL's number of single triangles; 5 is a strip


def parse_sciss(data: bytes, _: Size, where: str) -> MeasuredMesh:
    """Parse a warp mesh of SCISS's Uniview, ``.sgc``.

    Little-endian: ``SGC``, a byte for the version (1, 2, or the digit of it), a type (0: planar),
    the rotation of the view as a quaternion x, y, z, w and its place, right-handed with z astern,
    the angles of its edges up, down, left, right (down and left usually negative), two sizes, nodes
    of six numbers, the number of indices, and those. The sizes of version 1 are columns and rows of
    the nodes, those of version 2 the kind of triangles (4: one by one, 5: a strip) and the number
    of nodes. A node is x, y (from the upper left corner) and z of the projector, u, v (from the
    lower left) and w of the picture (SGCT: src/correction/sciss.cpp; files of its repository,
    e143ee02, 752af4ed, 19bbd93c).
    """
    if data[:3] != b"SGC" or len(data) < SGC_HEADER:
        raise UserError("not an SGC file, expected 'SGC' and a header of 60 bytes", file=where)
    version = data[3] - ord("0") if data[3] >= ord("0") else data[3]
    kind, *numbers, first, second = struct.unpack_from("<I11f2I", data, 4)
    if version not in (1, 2):
        raise UserError(f"version {version} of SGC, expected 1 or 2", file=where)
    if kind != 0:
        raise UserError(f"mapping {kind} (a cube), expected 0 (planar)", file=where)
    if not np.isfinite(numbers).all():
        raise UserError("its view has numbers that are not finite", file=where)
    count = second if version == 2 else first * second
    at = SGC_HEADER + SGC_NODE * count
    if count < 3 or len(data) < at + 4:
        raise UserError(f"{count} nodes in {len(data)} bytes, expected fewer", file=where)
    nodes = np.frombuffer(data, "<f4", 6 * count, SGC_HEADER).reshape(count, 6).astype(np.float64)
    (indices,) = struct.unpack_from("<I", data, at)
    if indices < 3 or len(data) != at + 4 + 4 * indices:
        raise UserError(
            f"{indices} indices in {len(data) - at - 4} bytes, expected 4 bytes each", file=where
        )
    order = np.frombuffer(data, "<u4", indices, at + 4).astype(np.int64)
    triangles: Ints = order[: indices - indices % 3].reshape(-1, 3)
    if version == 1 or first != SGC_TRIANGLES:
        triangles = strip_triangles(order)
    places = np.column_stack([nodes[:, 0], 1.0 - nodes[:, 1]])
    up, down, left, right = numbers[7:]
    view = ViewAngles(*turned(quaternion_rotation(np.array(numbers[:4]))), left, right, down, up)
    notes: tuple[str, ...] = ()
    if any(numbers[4:7]):
        notes = (f"{where}: the place {numbers[4]:g}, {numbers[5]:g}, {numbers[6]:g} of its view",)
    warp = node_mesh(places, nodes[:, 3:5], triangles, where)
    return MeasuredMesh(warp, view=view, notes=notes)


CSV_NAMES = "x y u v column row"
FRUSTUM_NAMES = ("heading", "pitch", "bank", "left", "right", "bottom", "top")


def parse_domeprojection(data: bytes, _: Size, where: str) -> MeasuredMesh:
    """Parse a warp mesh of domeprojection.com, ``.csv``.

    A line ``x;y;u;v;column;row``, then a node a line. x and y are shares of the projector, u and v
    of the picture, both from the upper left corner; columns and rows are counted from 0
    (SGCT: src/correction/domeprojection.cpp; files of its repository, 19bbd93c, e143ee02).
    """
    names = CSV_NAMES.split()
    nodes = []
    for number, words in text_rows(data, where, ";"):
        if words[0][:1].isalpha():
            names = [word.lower() for word in words]
            if missing := [name for name in CSV_NAMES.split() if name not in names]:
                raise UserError(f"no column {missing[0]!r}, expected {CSV_NAMES}", file=where)
            continue
        row = numbers_of(words, len(names), f"{where}: line {number}", " ".join(names))
        nodes.append([row[names.index(name)] for name in CSV_NAMES.split()])
    if not nodes:
        raise UserError(f"no nodes, expected lines of {CSV_NAMES.replace(' ', ';')}", file=where)
    table = np.array(nodes)
    grid = table[:, 4:]
    if not np.isfinite(grid).all() or grid.min() < 0 or (grid != np.floor(grid)).any():
        raise UserError("its columns and rows are not whole numbers from 0", file=where)
    across, up = grid.max(axis=0) + 1
    check_grid(across, up, where)
    columns, rows = int(across), int(up)
    at = (grid[:, 1] * columns + grid[:, 0]).astype(np.int64)
    placed = np.full((columns * rows, 4), np.nan)  # a node that is not listed stays dark
    placed[at] = table[:, :4]
    places = np.column_stack([placed[:, 0], 1.0 - placed[:, 1]])
    sources = np.column_stack([placed[:, 2], 1.0 - placed[:, 3]])
    return MeasuredMesh(node_mesh(places, sources, grid_triangles(columns, rows), where))


def parse_frustum(data: bytes, where: str) -> ViewAngles:
    """Parse the view of a mesh, in the file beside it.

    A line of names and a line of numbers, with ``heading`` (right positive), ``pitch`` (up),
    ``bank``, ``left`` and ``right`` (both positive outwards), ``bottom`` and ``top`` (both positive
    upwards), in degrees.
    """
    rows = list(text_rows(data, where, ";"))[:2]
    if len(rows) < 2 or len(rows[1][1]) < len(rows[0][1]):
        raise UserError("expected a line of names and a line of numbers", file=where)
    (_, names), (number, cells) = rows
    table = dict(zip(names, cells, strict=False))
    words = [table.get(key, "") for key in FRUSTUM_NAMES]
    heading, pitch, bank, left, right, bottom, top = numbers_of(
        words, len(words), f"{where}: line {number}", " ".join(FRUSTUM_NAMES)
    )
    return ViewAngles(heading, pitch, bank, -left, right, bottom, top)


def parse_simcad(data: bytes, _: Size, where: str) -> MeasuredMesh:
    """Parse a warp file of SimCAD's geometry correction, ``.simcad``.

    XML: ``GeometryFile/GeometryDefinition`` with ``X-FlatParameters`` and ``Y-FlatParameters``.
    Each has a ``range`` in pixels and the offsets of a square grid of nodes, 33×33, row after row
    from the upper left corner, to the right and down (SGCT: src/correction/simcad.cpp; its
    repository, 19bbd93c, has a dome of six projectors, and the same warps as SGC and CSV).
    """
    root = parse_xml(data, where)
    definition = root.find("geometrydefinition")
    if root.tag != "geometryfile" or definition is None:
        raise UserError("expected 'GeometryFile' with a 'GeometryDefinition'", file=where)
    offsets = []
    for name in ("X-FlatParameters", "Y-FlatParameters"):
        element = definition.find(name.lower())
        if element is None:
            raise UserError(f"{name!r} is missing", file=where)
        (extent,) = numbers_of([element.get("range", "")], 1, where, f"'range' of {name}")
        if not (math.isfinite(extent) and extent > 0):
            raise UserError(f"{name}: range {extent:g}, expected a number above 0", file=where)
        words = (element.text or "").split()
        offsets.append(np.array(numbers_of(words, len(words), where, f"of {name}")) / extent)
    right, down = offsets
    side = math.isqrt(len(right))
    if side * side != len(right) or len(right) != len(down):
        counts = f"{len(right)} and {len(down)}"
        raise UserError(f"{counts} offsets, expected twice the same square number", file=where)
    check_grid(side, side, where)
    sources = regular_sources(side, side)
    places = sources + np.column_stack([right, -down])
    return MeasuredMesh(node_mesh(places, sources, grid_triangles(side, side), where))


EDGES = ("LEFT", "RIGHT", "BOTTOM", "TOP")
OL_TURNS = ("YAW", "PITCH", "ROLL")
OL_KEYS = {"VERTICES", "FACES", "NATIVEXRES", "NATIVEYRES"}.union(
    [f"ORTHO_{edge}" for edge in EDGES],
    [f"PERSPECTIVE_{part}" for part in (*EDGES, *OL_TURNS)],
)


def parse_scalable(data: bytes, size: Size, where: str) -> MeasuredMesh:
    """Parse a warp mesh of Scalable Display's OPENMESH, ``.ol``.

    Lines of a keyword and its value: ``VERTICES`` and ``FACES`` (how many), ``NATIVEXRES`` and
    ``NATIVEYRES`` (pixels), ``ORTHO_LEFT`` … ``ORTHO_TOP`` (edges of the projector in shares of
    those), ``PERSPECTIVE_LEFT`` … ``PERSPECTIVE_TOP`` (edges of the view in degrees, left and
    bottom usually negative) with ``PERSPECTIVE_YAW`` (to the left), ``PERSPECTIVE_PITCH`` (up) and
    ``PERSPECTIVE_ROLL`` (counterclockwise). A node is a line ``x y brightness s t``, x and y in
    pixels from the lower left corner, brightness to 255, u = 1 - t and v = 1 - s; a face is
    ``[ a b c ]``. No example file is public: this follows SGCT's reader
    (src/correction/scalable.cpp).
    """
    keys: dict[str, float] = {}
    nodes: list[list[float]] = []
    faces: list[list[float]] = []
    notes: list[str] = []
    for number, (first, *words) in text_rows(data, where):
        at = f"{where}: line {number}"
        if first[0] == "[":
            face = " ".join([first, *words]).strip("[] ").split()
            if len(face) != 3:
                raise UserError(f"{at}: a face of {len(face)} nodes, expected 3")
            faces.append(numbers_of(face, 3, at, "a b c of a face"))
        elif first.upper() in OL_KEYS:
            (keys[first.upper()],) = numbers_of(words, 1, at, f"of {first}")
        elif first.startswith(("ORTHO_", "PERSPECTIVE_")):
            notes.append(f"{at}: {first[:40]}, which may change the view")
        elif first[0].isalpha():
            continue  # text such as `MAPPING NORMALIZED` has no use
        else:
            nodes.append(numbers_of([first, *words], 5, at, "x y brightness s t"))
    for name, lines in (("VERTICES", nodes), ("FACES", faces)):
        if keys.get(name) != len(lines) or not lines:
            said = keys.get(name, float("nan"))
            raise UserError(f"{name} {said:g}, but {len(lines)} lines of them", file=where)
    x, y, brightness, s, t = np.array(nodes).T
    left, right, bottom, top = (
        keys.get(f"ORTHO_{edge}", default)
        for edge, default in zip(EDGES, (0.0, 1.0, 0.0, 1.0), strict=True)
    )
    across, up = keys.get("NATIVEXRES", 0.0), keys.get("NATIVEYRES", 0.0)
    spans = np.array([across, up, right - left, top - bottom])
    if not np.isfinite(spans).all() or (np.abs(spans) < 1e-9).any():
        raise UserError("NATIVEXRES, NATIVEYRES or ORTHO_… have no area", file=where)
    with np.errstate(over="ignore", invalid="ignore"):
        places = np.column_stack([(x / across - left) / spans[2], (y / up - bottom) / spans[3]])
        sources = np.column_stack([1.0 - t, 1.0 - s])
    order = np.nan_to_num(np.array(faces), nan=-1.0, posinf=-1.0, neginf=-1.0)
    triangles = np.clip(order, -1, len(nodes)).astype(np.int64)
    warp = node_mesh(places, sources, triangles, where)
    light = np.clip(np.nan_to_num(brightness) / 255.0, 0.0, 1.0)
    mask = None
    if light.min() < 1.0:
        whole = mesh(np.nan_to_num(np.clip(places, -1, 2)), sources, triangles)
        mask = _brightness_mask(whole, light, size)
    return MeasuredMesh(warp, mask, _scalable_view(keys), tuple(notes))


def _scalable_view(keys: dict[str, float]) -> ViewAngles | None:
    if not any(f"PERSPECTIVE_{edge}" in keys for edge in EDGES):
        return None
    yaw, pitch, roll = (keys.get(f"PERSPECTIVE_{n}", 0.0) for n in OL_TURNS)
    turn = turned(turns(2, roll) @ turns(1, yaw) @ turns(0, pitch))
    left, right, bottom, top = (keys.get(f"PERSPECTIVE_{edge}", 0.0) for edge in EDGES)
    return ViewAngles(*turn, left, right, bottom, top)


SKYSKAN_KEYS = {
    "dome azimuth", "dome elevation", "horizontal fov", "vertical fov", "u tweak", "v tweak",
    "horizontal tweak", "vertical tweak",
}  # fmt: skip
SKYSKAN_HIGH = 1200 / 2048  # height of a view of unknown height, in shares of its width


def parse_skyskan(data: bytes, _: Size, where: str) -> MeasuredMesh:
    """Parse a warp mesh of Sky-Skan's DigitalSky, ``.skyskan``.

    Lines ``Dome Azimuth=``, ``Dome Elevation=``, ``Horizontal FOV=``, ``Vertical FOV=`` (degrees)
    and ``U Tweak=``, ``V Tweak=``, ``Horizontal Tweak=``, ``Vertical Tweak=`` (factors; negative:
    none), a line of columns and rows, and a node a line: x y u v, shares from the upper left
    corner; a node with x or y of -1 is not used. No example file is public: this follows SGCT's
    reader (src/correction/skyskan.cpp), which also gives the height of a view without
    ``Vertical FOV``.
    """
    keys: dict[str, float] = {}
    table: list[list[float]] = []  # the size, then the nodes
    notes: list[str] = []
    for number, words in text_rows(data, where):
        at = f"{where}: line {number}"
        name, equals, value = (part.strip() for part in " ".join(words).partition("="))
        if equals and name.lower() not in SKYSKAN_KEYS:
            notes.append(f"{at}: {name[:40]!r}, which may change the view")
        elif equals:
            (keys[name.lower()],) = numbers_of([value], 1, at, f"of {name!r}")
        elif table:
            table.append(numbers_of(words, 4, at, "x y u v"))
        else:
            across, up = numbers_of(words, 2, at, "columns rows")
            check_grid(across, up, where)
            table.append([across, up])
    columns, rows = map(int, table[0] if table else (0, 0))
    if not table or len(table) - 1 != columns * rows:
        raise UserError(
            f"{max(len(table) - 1, 0)} nodes, expected a line of columns and rows, and those",
            file=where,
        )
    x, y, u, v = np.array(table[1:]).T
    u_tweak, v_tweak = (keys.get(f"{axis} tweak", 1.0) for axis in "uv")
    u, v = u * (u_tweak if u_tweak > -1 else 1.0), v * (v_tweak if v_tweak > -1 else 1.0)
    unused = (x == -1.0) | (y == -1.0)
    places = np.column_stack([np.where(unused, np.nan, x), 1.0 - y])
    warp = node_mesh(places, np.column_stack([u, 1.0 - v]), grid_triangles(columns, rows), where)
    return MeasuredMesh(warp, view=_skyskan_view(keys, where), notes=tuple(notes))


def _skyskan_view(keys: dict[str, float], where: str) -> ViewAngles:
    names = ("dome azimuth", "dome elevation", "horizontal fov")
    if missing := [name for name in names if not math.isfinite(keys.get(name, math.nan))]:
        raise UserError(f"expected a line '{missing[0].title()}='", file=where)
    azimuth, elevation, across = (keys[name] for name in names)
    up = keys.get("vertical fov", 0.0)
    if not 0 < across < 178:
        raise UserError(f"Horizontal FOV {across:g}, expected an angle below 178", file=where)
    if not 0 < up < 178:
        up = 2 * math.degrees(math.atan(SKYSKAN_HIGH * math.tan(math.radians(across / 2))))
    wide, high = (keys.get(f"{axis} tweak", 1.0) for axis in ("horizontal", "vertical"))
    across *= wide if 0 < wide < 10 else 1.0
    up *= high if 0 < high < 10 else 1.0
    return ViewAngles(azimuth, elevation, 0.0, -across / 2, across / 2, -up / 2, up / 2)


FORMATS: dict[str, Callable[[bytes, Size, str], MeasuredMesh]] = {
    ".obj": parse_obj,
    ".pfm": _parse_pfm,
    ".data": parse_bourke,
    ".sgc": parse_sciss,
    ".csv": parse_domeprojection,
    ".simcad": parse_simcad,
    ".ol": parse_scalable,
    ".skyskan": parse_skyskan,
    ".vwf": parse_vioso,
}
