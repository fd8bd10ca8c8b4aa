"""Warp meshes of SCISS's Uniview, ``.sgc``.

Little-endian: ``SGC``, a byte for the version (1, 2, or the digit of it), a type (0: planar), the
rotation of the view as a quaternion x, y, z, w and its place, right-handed with z astern, the
angles of its edges up, down, left, right (down and left usually negative), two sizes, nodes of six
numbers, the number of indices, and those. The sizes of version 1 are columns and rows of the nodes,
those of version 2 the kind of triangles (4: one by one, 5: a strip) and the number of nodes. A node
is x, y (from the upper left corner) and z of the projector, u, v (from the lower left) and w of the
picture (SGCT: src/correction/sciss.cpp; files of its repository, e143ee02, 752af4ed, 19bbd93c).
"""

import struct

import numpy as np

from subsea.base.arrays import Ints
from subsea.base.errors import UserError
from subsea.stage.theatre.measured_mesh import (
    MAX_NODES,
    MAX_TRIANGLES,
    MeasuredMesh,
    ViewAngles,
    node_mesh,
    quaternion_rotation,
    strip_triangles,
    turned,
)

MAX_BYTES = 64 * 2**20
HEADER, NODE = 60, 24  # bytes
TRIANGLES = 4  # OpenGL's number of single ones; 5 is a strip
PLANAR = 0


def parse_sciss(data: bytes, where: str) -> MeasuredMesh:
    """The warp and the view of a file's bytes; a UserError names `where`."""
    if data[:3] != b"SGC" or len(data) < HEADER:
        raise UserError("not an SGC file, expected 'SGC' and a header of 60 bytes", file=where)
    version = data[3] - ord("0") if data[3] >= ord("0") else data[3]
    kind, *numbers, first, second = struct.unpack_from("<I11f2I", data, 4)
    if version not in (1, 2):
        raise UserError(f"version {version} of SGC, expected 1 or 2", file=where)
    if kind != PLANAR:
        raise UserError(f"mapping {kind} (a cube), expected 0 (planar)", file=where)
    if not np.isfinite(numbers).all():
        raise UserError("its view has numbers that are not finite", file=where)
    count = second if version == 2 else first * second
    if not 3 <= count <= MAX_NODES or len(data) < HEADER + NODE * count + 4:
        raise UserError(f"{count} nodes in {len(data)} bytes, expected fewer", file=where)
    nodes = np.frombuffer(data, "<f4", 6 * count, HEADER).reshape(count, 6).astype(np.float64)
    at = HEADER + NODE * count
    (indices,) = struct.unpack_from("<I", data, at)
    if not 3 <= indices <= 3 * MAX_TRIANGLES or len(data) != at + 4 + 4 * indices:
        raise UserError(
            f"{indices} indices in {len(data) - at - 4} bytes, expected 4 bytes each", file=where
        )
    order = np.frombuffer(data, "<u4", indices, at + 4).astype(np.int64)
    single = version == 2 and first == TRIANGLES
    triangles: Ints = order[: indices - indices % 3].reshape(-1, 3)
    if not single:
        triangles = strip_triangles(order)
    places = np.column_stack([nodes[:, 0], 1.0 - nodes[:, 1]])
    up, down, left, right = numbers[7:]
    heading, pitch, roll = turned(quaternion_rotation(np.array(numbers[:4])))
    notes: tuple[str, ...] = ()
    if any(numbers[4:7]):
        notes = (f"{where}: the place {numbers[4]:g}, {numbers[5]:g}, {numbers[6]:g} of its view",)
    return MeasuredMesh(
        node_mesh(places, nodes[:, 3:5], triangles, where),
        view=ViewAngles(heading, pitch, roll, left, right, down, up),
        notes=notes,
    )
