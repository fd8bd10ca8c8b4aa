"""Warp meshes of Wavefront OBJ files.

``v x y z`` is a point on the projector, ``vt u v`` one of the picture that is shown, ``f`` a
polygon of both. As in SGCT (src/sgct/correction/obj.cpp) and in Sparck's MeshWarp, x and y run from
-1 on the left and below to 1; a mesh with neither x nor y below -0.5 is taken as one from 0 to 1,
as other tools write it. z is ignored. u and v run from 0, on the left and below, to 1.
"""

import itertools

import numpy as np

from subsea.base.errors import UserError
from subsea.stage.theatre.numbered_lines import numbered_lines
from subsea.stage.theatre.warp import mesh, validated
from subsea.view.rig import Warp

# Other statements of OBJ files: normals, parameters, groups, smoothing, lines, materials.
IGNORED = ("vn", "vp", "g", "o", "s", "l", "p", "mtllib", "usemtl", "mg", "lod")


def parse_obj(data: bytes, where: str) -> Warp:
    """A warp from a file's bytes; a UserError names `where`, and the line or how much is wrong."""
    return validated(obj_mesh(data, where), where)


def obj_mesh(data: bytes, where: str, signed: bool = False) -> Warp:
    """The mesh in a file's bytes as it is, not yet checked; a UserError names `where`.

    `signed`: x and y are from -1 to 1, whatever they are.
    """
    points: list[list[float]] = []
    shown: list[list[float]] = []
    corners: list[tuple[int, int]] = []  # of all faces: indices of a point and its source
    triangles: list[tuple[int, int, int]] = []  # indices of corners
    for number, (kind, *words) in numbered_lines(data, where):
        at = f"{where}: line {number}"
        if kind == "v":
            points.append(_numbers(words, ("x", "y"), at))
        elif kind == "vt":
            shown.append(_numbers(words, ("u", "v"), at))
        elif kind == "f":
            first = len(corners)
            corners.extend(_corner(word, len(points), len(shown), at) for word in words)
            if len(words) < 3:
                raise UserError(f"{at}: a face of {len(words)} corners, expected 3 or more")
            rest = range(first + 1, len(corners))
            triangles.extend((first, i, j) for i, j in itertools.pairwise(rest))
        elif kind not in IGNORED:
            raise UserError(f"{at}: {kind[:20]!r} is not a keyword of OBJ files")
    if not triangles:
        raise UserError("an empty mesh, expected 'v', 'vt' and 'f' lines", file=where)
    used, numbers = np.unique(np.array(corners), axis=0, return_inverse=True)
    places = np.array(points)[used[:, 0]]
    if signed or places.min() < -0.5:
        places = (places + 1) / 2
    faces = numbers.reshape(-1)[np.array(triangles)]
    return mesh(places, np.array(shown)[used[:, 1]], faces)


def _numbers(words: list[str], names: tuple[str, ...], at: str) -> list[float]:
    """The first numbers of a line; others, such as z or a colour, are ignored."""
    try:
        return [float(words[k]) for k in range(len(names))]
    except (ValueError, IndexError) as fault:
        raise UserError(f"{at}: expected the numbers {' '.join(names)}") from fault


def _corner(word: str, points: int, shown: int, at: str) -> tuple[int, int]:
    """Point and source indices, from 0, of a corner such as 3/5 or -1/-1/2; 3 is 3/3."""
    parts = word.split("/")
    try:
        point = int(parts[0])
        source = int(parts[1]) if len(parts) > 1 and parts[1] else point
    except ValueError as fault:
        raise UserError(f"{at}: corner {word[:40]!r}, expected numbers such as 3/3") from fault
    point += points + 1 if point < 0 else 0
    source += shown + 1 if source < 0 else 0
    if not 1 <= point <= points:
        raise UserError(f"{at}: corner {word[:40]!r}, expected one of {points} 'v' lines before it")
    if not 1 <= source <= shown:
        raise UserError(f"{at}: corner {word[:40]!r}, expected one of {shown} 'vt' lines before it")
    return point - 1, source - 1
