"""ICC profiles of wide gamuts and of inks, with colours that are computed without them."""

import struct

import numpy as np

D65, D50 = np.array([0.95047, 1.0, 1.08883]), np.array([0.9642, 1.0, 0.8249])
BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
SRGB = np.array([(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)])
DISPLAY_P3 = np.array([(0.680, 0.320), (0.265, 0.690), (0.150, 0.060)])
ADOBE_RGB = np.array([(0.64, 0.33), (0.21, 0.71), (0.15, 0.06)])
INKS = np.array([(0, 160, 220), (230, 0, 130), (255, 230, 0), (40, 40, 40)]) / 255.0  # sRGB


def to_xyz(primaries):
    """The matrix from linear RGB with white D65 to XYZ."""
    xyz = np.array([(x / y, 1.0, (1.0 - x - y) / y) for x, y in primaries]).T
    return xyz * np.linalg.solve(xyz, D65)


def linear(values):
    """Undo the curve of sRGB."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def coded(light):
    """Apply the curve of sRGB to light in its gamut."""
    light = np.clip(light, 0.0, 1.0)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)


def in_srgb(colours, primaries, gamma=None):
    """Levels (..., 3) of 8 bits in sRGB of levels with other primaries, by their curve."""
    values = np.asarray(colours) / 255.0
    light = linear(values) if gamma is None else values**gamma
    light = light @ np.linalg.solve(to_xyz(SRGB), to_xyz(primaries)).T
    return np.rint(255.0 * coded(light)).astype(int)


def printed(amounts):
    """Levels (..., 3) in sRGB of amounts (..., 4) of the INKS, each 0 or 1: they multiply light."""
    amounts = np.asarray(amounts)[..., None]
    return np.rint(255.0 * coded(linear(1.0 + amounts * (INKS - 1.0)).prod(axis=-2))).astype(int)


def rgb_profile(primaries, gamma=None):
    """An ICC profile of primaries with white D65; the curve is that of sRGB without a `gamma`."""
    adapt = np.linalg.solve(BRADFORD, (BRADFORD @ D50 / (BRADFORD @ D65))[:, None] * BRADFORD)
    columns = (adapt @ to_xyz(primaries)).T
    curve = b"curv" + struct.pack(">4xIH", 1, round(256 * (gamma or 1.0)))
    if gamma is None:
        numbers = 2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045
        curve = b"para" + struct.pack(">4xHH5i", 3, 0, *(round(65536 * n) for n in numbers))
    tags = {b"wtpt": _xyz(D50)}
    for name, column in zip((b"r", b"g", b"b"), columns, strict=True):
        tags |= {name + b"XYZ": _xyz(column), name + b"TRC": curve}
    return _profile(b"mntr", b"RGB ", b"XYZ ", tags)


def grey_profile(gamma):
    """An ICC profile of greys."""
    curve = b"curv" + struct.pack(">4xIH", 1, round(256 * gamma))
    return _profile(b"mntr", b"GRAY", b"XYZ ", {b"wtpt": _xyz(D50), b"kTRC": curve})


def ink_profile():
    """An ICC profile of the INKS, a table with two levels of each ink."""
    amounts = np.stack(np.meshgrid(*4 * [[0.0, 1.0]], indexing="ij"), axis=-1).reshape(-1, 4)
    adapt = np.linalg.solve(BRADFORD, (BRADFORD @ D50 / (BRADFORD @ D65))[:, None] * BRADFORD)
    xyz = linear(printed(amounts) / 255.0) @ (adapt @ to_xyz(SRGB)).T / D50
    f = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz / (3 * (6 / 29) ** 2) + 4 / 29)
    lab = [116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])]
    table = np.stack([lab[0] * 652.8, (lab[1] + 128) * 256, (lab[2] + 128) * 256], axis=1)
    words = np.rint(table.clip(0, 65535)).astype(">u2").tobytes()
    matrix = struct.pack(">9i", *(65536 * k for k in (1, 0, 0, 0, 1, 0, 0, 0, 1)))
    ends = struct.pack(">2H", 0, 65535)
    head = b"mft2" + struct.pack(">4x4B", 4, 3, 2, 0) + matrix + struct.pack(">2H", 2, 2)
    tags = {b"wtpt": _xyz(D50), b"A2B0": head + 4 * ends + words + 3 * ends}
    return _profile(b"prtr", b"CMYK", b"Lab ", tags)


def _xyz(values):
    return b"XYZ " + struct.pack(">4x3i", *(round(65536 * float(v)) for v in values))


def _profile(kind, space, connection, tags):
    """Lay out a profile of version 2.4."""
    at, index, body = 132 + 12 * len(tags), b"", b""
    for name, data in tags.items():
        index += name + struct.pack(">2I", at + len(body), len(data))
        body += data + bytes(-len(data) % 4)
    head = struct.pack(">I4xI4s4s4s12x4s", at + len(body), 0x02400000, kind, space, connection,
                       b"acsp")  # fmt: skip
    head += bytes(28) + struct.pack(">3i", *(round(65536 * v) for v in D50))
    return head.ljust(128, b"\0") + struct.pack(">I", len(tags)) + index + body
