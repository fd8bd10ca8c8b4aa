"""Small synthetic theatre files of other programs, for tests and for `tools/fuzz.py`.

Every mesh shows `bend` of a place: it is affine, so that any mesh of it is exact.
"""

import io
import json
import struct
import zipfile
from typing import Any

import numpy as np
from PIL import Image

COLUMNS, ROWS = 7, 5
VIEW = {"heading": 20.0, "pitch": 10.0, "roll": 0.0, "left": -30.0, "right": 40.0, "down": -20.0}
VIEW["up"] = 25.0


def bend(x: Any, y: Any) -> tuple[Any, Any]:
    """The source of a place, both as shares from the lower left."""
    return 0.1 + 0.7 * x + 0.05 * y, 0.15 + 0.6 * y - 0.05 * x


def grid() -> tuple[np.ndarray, np.ndarray]:
    """x and y of the nodes, row after row from the upper left."""
    x, y = np.meshgrid(np.linspace(0, 1, COLUMNS), np.linspace(1, 0, ROWS))
    return x.ravel(), y.ravel()


def cells() -> np.ndarray:
    """Triangles (n, 3) of the grid."""
    a = (np.arange(ROWS - 1)[:, None] * COLUMNS + np.arange(COLUMNS - 1)).ravel()
    below = a + COLUMNS
    return np.concatenate([np.stack([a, a + 1, below + 1], 1), np.stack([a, below + 1, below], 1)])


def strip() -> np.ndarray:
    """One strip of triangles, to the right in even rows and back in odd ones."""
    order: list[int] = []
    for row in range(ROWS - 1):
        columns = range(COLUMNS) if row % 2 == 0 else range(COLUMNS - 1, -1, -1)
        for column in columns:
            order += [row * COLUMNS + column, (row + 1) * COLUMNS + column]
    return np.array(order)


def sgc(version: int = 2, triangles: bool = True) -> bytes:
    """A mesh of SCISS: version 1, or 2 with single triangles or a strip."""
    x, y = grid()
    u, v = bend(x, y)
    half_yaw, half_pitch = np.radians(-VIEW["heading"]) / 2, np.radians(VIEW["pitch"]) / 2
    # A turn about y, then one about x.
    quaternion = (
        np.cos(half_yaw) * np.sin(half_pitch), np.sin(half_yaw) * np.cos(half_pitch),
        -np.sin(half_yaw) * np.sin(half_pitch), np.cos(half_yaw) * np.cos(half_pitch),
    )  # fmt: skip
    edges = (VIEW[name] for name in ("up", "down", "left", "right"))
    sizes = (COLUMNS, ROWS) if version == 1 else (4 if triangles else 5, len(x))
    order = cells().ravel() if version == 2 and triangles else strip()
    nodes = np.column_stack([x, 1 - y, 0 * x, u, v, 0 * x]).astype("<f4")
    head = struct.pack("<I11f2I", 0, *quaternion, 0, 0, 0, *edges, *sizes)
    body = nodes.tobytes() + struct.pack("<I", order.size) + order.astype("<u4").tobytes()
    return b"SGC" + bytes([version]) + head + body


def csv() -> bytes:
    """A mesh of domeprojection."""
    x, y = grid()
    u, v = bend(x, y)
    lines = ["x;y;u;v;column;row"]
    for k in range(len(x)):
        numbers = ";".join(f"{number:.7f}" for number in (x[k], 1 - y[k], u[k], 1 - v[k]))
        lines.append(f"{numbers};{k % COLUMNS};{k // COLUMNS}")
    return ("\n".join(lines) + "\n").encode()


def frustum() -> bytes:
    """The view beside such a mesh."""
    numbers = [0, 0, 0, VIEW["heading"], VIEW["pitch"], 0, -VIEW["left"], VIEW["right"]]
    numbers += [VIEW["down"], VIEW["up"]]
    names = "x;y;z;heading;pitch;bank;left;right;bottom;top"
    return f"{names}\n{';'.join(f'{number:.6f}' for number in numbers)}\n".encode()


def simcad(side: int = 6) -> bytes:
    """A warp of SimCAD: where a regular grid of the picture is on the projector."""
    u, v = (one.ravel() for one in np.meshgrid(np.linspace(0, 1, side), np.linspace(1, 0, side)))
    # The place of a source is found by solving `bend`.
    turn = np.array([[0.7, 0.05], [-0.05, 0.6]])
    x, y = np.linalg.solve(turn, np.stack([u - 0.1, v - 0.15]))
    right = " ".join(f"{number:.9f}" for number in (x - u) * 1920)
    down = " ".join(f"{number:.9f}" for number in (v - y) * 1080)
    return (
        '<?xml version="1.0"?>\n<GeometryFile>\n<GeometryDefinition>\n'
        f'<X-FlatParameters range="1920">{right}</X-FlatParameters>\n'
        f'<Y-FlatParameters range="1080">{down}</Y-FlatParameters>\n'
        "</GeometryDefinition>\n</GeometryFile>\n"
    ).encode()


def ol(brightness: int = 255) -> bytes:
    """A mesh of Scalable Display."""
    x, y = grid()
    u, v = bend(x, y)
    lines = ["OPENMESH Version 1.1", f"VERTICES {len(x)}", f"FACES {len(cells())}"]
    lines += ["MAPPING NORMALIZED", "NATIVEXRES 1920", "NATIVEYRES 1080"]
    lines += ["ORTHO_LEFT 0", "ORTHO_RIGHT 1", "ORTHO_BOTTOM 0", "ORTHO_TOP 1"]
    lines += [f"PERSPECTIVE_{key} {VIEW[name]}" for key, name in (
        ("LEFT", "left"), ("RIGHT", "right"), ("BOTTOM", "down"), ("TOP", "up"),
    )]  # fmt: skip
    # With a turn about two axes the order would matter.
    lines += [f"PERSPECTIVE_YAW {-VIEW['heading']}", "PERSPECTIVE_PITCH 0"]
    lines += [
        f"{1920 * x[k]:.6f} {1080 * y[k]:.6f} {brightness} {1 - v[k]:.7f} {1 - u[k]:.7f}"
        for k in range(len(x))
    ]
    lines += [f"[ {a} {b} {c} ]" for a, b, c in cells()]
    return ("\n".join(lines) + "\n").encode()


def skyskan() -> bytes:
    """A mesh of Sky-Skan."""
    x, y = grid()
    u, v = bend(x, y)
    lines = [f"Dome Azimuth={VIEW['heading']}", f"Dome Elevation={VIEW['pitch']}"]
    lines += ["Horizontal FOV=80", "Vertical FOV=50", f"{COLUMNS} {ROWS}"]
    lines += [f"{x[k]:.7f} {1 - y[k]:.7f} {u[k]:.7f} {1 - v[k]:.7f}" for k in range(len(x))]
    return ("\n".join(lines) + "\n").encode()


def vwf(maps: int = 1, bits: int = 24, size: tuple[int, int] = (16, 12)) -> bytes:
    """Maps of VIOSO, each with a bitmap that halves red."""
    width, height = size
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, 1 - (np.arange(height) + 0.5) / height)
    u, v = bend(x, y)
    records = np.dstack([u, 1 - v, np.ones_like(u), 0 * u]).astype("<f4").tobytes()
    blocks = b""
    for number in range(maps):
        head = b"vwf0" + struct.pack("<4I2i", 380, 0, 0x10001, len(records), width, height)
        blocks += (head + bytes(96) + f"beamer {number}".encode()).ljust(380, b"\0") + records
        blocks += bitmap(size, bits)
    return b"vwf1" + struct.pack("<3I", 2 * maps, 16, 0) + blocks


def mpcdi() -> bytes:
    """An archive of MPCDI with one projector, a warp and an alpha map."""
    xml = (
        '<MPCDI profile="2d"><display><buffer id="b">\n'
        '<region id="r" Xresolution="64" Yresolution="48" x="0" y="0" xsize="1" ysize="1"/>\n'
        '</buffer></display>\n<files><fileset region="r">\n'
        "<geometryWarpFile><path>warp.pfm</path></geometryWarpFile>\n<alphaMap>"
        "<path>alpha.png</path><gammaEmbedded>2.2</gammaEmbedded></alphaMap>\n</fileset></files></MPCDI>\n"
    )
    x, y = np.meshgrid(np.linspace(0, 1, 16), np.linspace(0, 1, 12))
    alpha, packed = io.BytesIO(), io.BytesIO()
    Image.effect_noise((16, 12), 60.0).save(alpha, "PNG")
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("mpcdi.xml", xml)
        warp = np.dstack([x, y, 0 * x]).astype("<f4").tobytes()
        archive.writestr("warp.pfm", b"PF\n16 12\n-1.0\n" + warp)
        archive.writestr("alpha.png", alpha.getvalue())
    return packed.getvalue()


def bitmap(size: tuple[int, int], bits: int) -> bytes:
    """A Windows bitmap of half red, full green and blue, 8, 16 or 32 (float) bits a colour."""
    width, height = size
    pixel = {
        24: bytes([255, 255, 128]), 32: bytes([255, 255, 128, 255]),
        64: struct.pack("<4H", 32896, 65535, 65535, 65535), 128: struct.pack("<4f", 0.5, 1, 1, 1),
    }[bits]  # fmt: skip
    row = pixel * width
    row += bytes(-len(row) % 4)
    head = struct.pack("<IHHI", 54 + len(row) * height, 0, 0, 54)
    return b"BM" + head + struct.pack("<I2i2H6I", 40, *size, 1, bits, *(0,) * 6) + row * height


def xyz(x: float, y: float, z: float) -> dict[str, float]:
    """A point of SGCT or nDisplay."""
    return {"x": x, "y": y, "z": z}


def sgct(viewports: list[dict[str, Any]] | None = None, **more: Any) -> dict[str, Any]:
    """A configuration of SGCT with one window; the viewports share it from the left."""
    planar = {"type": "PlanarProjection", "fov": {"hfov": 80.0, "vfov": 50.0}}
    viewports = viewports if viewports is not None else [{"projection": planar}]
    window = {"size": {"x": 640, "y": 360}, "pos": {"x": 10, "y": 20}, "viewports": viewports}
    node = {"address": "localhost", "port": 20400, "windows": [window]}
    users = [{"eyeseparation": 0.065, "pos": xyz(0.0, 0.0, 0.0)}]
    return {"version": 1, "masteraddress": "localhost", "nodes": [node], "users": users} | more


def viewports() -> list[dict[str, Any]]:
    """A viewport of each projection, side by side."""
    fov = {"left": 30.0, "right": 40.0, "down": 15.0, "up": 25.0}
    turn = {"yaw": 20.0, "pitch": 10.0, "roll": 5.0}
    crop = {"left": 0.0, "right": 0.1, "bottom": 0.2, "top": 0.0}
    faces = {face: f"{face}.obj" for face in ("bottom", "left", "right", "top")}
    projections: list[dict[str, Any]] = [
        {"type": "PlanarProjection", "fov": fov, "orientation": turn, "offset": xyz(0, 0, 1)},
        {"type": "PlanarProjection", "fov": {"hfov": 60.0, "vfov": 40.0}},
        {"type": "ProjectionPlane", "lowerleft": xyz(-1, -1, -2), "upperleft": xyz(-1, 1, -2),
         "upperright": xyz(1, 1, -2)},
        {"type": "FisheyeProjection", "fov": 200.0, "tilt": 20.0, "crop": crop},
        {"type": "EquirectangularProjection"},
        {"type": "CylindricalProjection", "radius": 4.0, "rotation": 0.5},
        {"type": "CubemapProjection", "channels": {"right": True, "top": False}},
        {"type": "SphericalMirrorProjection", "tilt": 10.0, "geometry": faces},
        {"type": "TextureMappedProjection", "fov": fov, "orientation": turn},
    ]  # fmt: skip
    meshes = {1: "mesh.sgc", 8: "mesh.pfm"}
    share = 1 / len(projections)
    return [
        {"projection": projection, "pos": {"x": k * share, "y": 0.0},
         "size": {"x": share, "y": 1.0}} | ({"mesh": meshes[k]} if k in meshes else {})
        for k, projection in enumerate(projections)
    ]  # fmt: skip


def ndisplay() -> dict[str, Any]:
    """A configuration of nDisplay: two screens on two computers, one of them of a left eye."""
    still = {"pitch": 0, "yaw": 0, "roll": 0}
    scene = {
        "xforms": {
            "origin": {"parentId": "", "location": xyz(0, 0, 10), "rotation": still},
            "side": {"parentId": "origin", "location": xyz(0, 0, 90),
                     "rotation": {"pitch": 0, "yaw": 90, "roll": 0}},
        },
        "cameras": {
            "head": {"interpupillaryDistance": 6.4, "stereoOffset": "none", "parentId": "origin",
                     "location": xyz(0, 0, 90), "rotation": still},
            "left": {"interpupillaryDistance": 6.4, "stereoOffset": "left", "parentId": "origin",
                     "location": xyz(0, 0, 90), "rotation": still},
        },
        "screens": {
            "front": {"size": {"width": 300, "height": 200}, "parentId": "origin",
                      "location": xyz(150, 0, 90), "rotation": still},
            "right": {"size": {"width": 300, "height": 200}, "parentId": "side",
                      "location": xyz(150, 0, 0), "rotation": still},
        },
    }  # fmt: skip

    def node(host: str, x: int, screen: str, camera: str) -> dict[str, Any]:
        policy = {"type": "simple", "parameters": {"screen": screen}}
        region = {"x": 0, "y": 0, "w": 600, "h": 400}
        viewport = {"camera": camera, "region": region, "projectionPolicy": policy}
        window = {"x": x, "y": 0, "w": 600, "h": 400}
        return {"host": host, "window": window, "fullScreen": False,
                "viewports": {f"vp_{screen}": viewport}}  # fmt: skip

    nodes = {"node_front": node("127.0.0.1", 0, "front", "head"),
             "node_right": node("127.0.0.1", 600, "right", "left")}  # fmt: skip
    cluster = {"primaryNode": {"id": "node_front"}, "nodes": nodes}
    return {"nDisplay": {"version": "5.00", "scene": scene, "cluster": cluster}}


def text(content: dict[str, Any]) -> bytes:
    """The bytes of a JSON file."""
    return json.dumps(content, indent=1).encode()
