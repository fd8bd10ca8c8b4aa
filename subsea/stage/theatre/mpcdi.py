"""MPCDI archives: the projectors of a theatre as a calibration program has measured them.

The format (VESA MPCDI 1.0 and 2.0) and the sources of these statements:

- A zip archive with ``mpcdi.xml`` (also seen: ``mpacs.xml``, ``mpcdi1_.xml``); all other files are
  found by path from there. The root ``MPCDI`` has ``profile``: 2d (media), 3d (simulation), a3
  (advanced 3-D) or sl (shader lamps). ``display`` holds ``buffer``s, a buffer ``region``s, one for
  each projector;
  ``files`` holds a ``fileset`` for each region: ``geometryWarpFile``, ``alphaMap``, ``betaMap``,
  ``distortionMap``, each with ``path`` (Scalable's MPCDI library: mpcdiReaderIntern.cpp,
  mpcdiXMLStrings.h, mpcdiProfile.cpp). Programs differ in capitals: Xresolution, xResolution.
- ``x y xsize ysize`` of a region are shares of its buffer from the lower left corner; the region
  is cut from the picture and then warped (PyMPCDI: MpacsWarp2DShader.py; nDisplay:
  CalcProfile2DScreen). Some programs write u and v as shares of the whole buffer instead
  (mpcdi-viewer, of a measured archive), which then fill just the region's place.
- The warp of 2d and 3d is a PFM grid over the projector, at the middles of its cells: u and v from
  the lower left; NaN where no picture is (mpcdi-viewer: shaders.ts; PyMPCDI: PfmMesh2D.py). Its
  lowest row comes first (mpcdiPfmIO.cpp). In a3 and sl it holds points in space.
- ``frustum`` of 3d: yaw to the right, then pitch up, then roll that raises the left wing, in
  degrees; leftAngle and downAngle are usually negative (Christie: MPCDI_explained.md).
- Final = (initial · a · (1 - b)) + b in light, not in code values, with a = alpha^gammaEmbedded and
  b = beta^gammaEmbedded, the alpha map's, for a beta map has none (MPCDI 2.0 §2.4, as nDisplay's
  MPCDIUtils.ush has it).
"""

import math
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from subsea.base.errors import UserError
from subsea.base.files import MIB, open_input
from subsea.stage.theatre.measured_mesh import ViewAngles
from subsea.stage.theatre.mesh_formats import MAX_BYTES, parse_xml, sources_of
from subsea.stage.theatre.pixel_files import parse_pfm, parse_png, stretched
from subsea.stage.theatre.warp import from_grid, validated, without_invalid
from subsea.view.rig import Rgb, Warp

Rect = tuple[float, float, float, float]
Fetch = Callable[[str, int], bytes | None]  # the content of a path in an archive, of limited size

MAX_XML = 4 * MIB
MAX_REGIONS = 256
MAX_PIXELS = 2**27  # of the maps of all regions together: eight projectors of 4K
MAX_SIDE = 2**14  # pixels of a projector
XML_NAMES = ("mpcdi.xml", "mpacs.xml", "mpcdi1_.xml")  # the last: SGCT's calibrator
PROFILES = {  # known, but not shown
    "a3": " (advanced 3-D) has points in space",
    "sl": " (shader lamps) has points in space",
}
USED = ("geometrywarpfile", "alphamap", "betamap")
AGREES = 0.02  # of a buffer: by which u and v that fill a region's place may miss its edges


class MpcdiRegion(NamedTuple):
    """The calibration of a projector."""

    name: str
    buffer: str
    size: tuple[int, int]  # pixels
    place: Rect  # x, y, width, height: shares of the buffer from its lower left corner
    frustum: ViewAngles | None = None
    warp: Warp | None = None  # u, v are shares of the region, not of the buffer
    alpha: NDArray[np.float32] | None = None  # (h, w, 3), upper row first: 0 to 1, as stored
    beta: NDArray[np.float32] | None = None  # (h, w, 3)
    gamma: float = 1.0  # of both maps


class MpcdiArchive(NamedTuple):
    """The usable projectors, and a line for each thing that cannot be used."""

    profile: str  # 2d or 3d
    regions: tuple[MpcdiRegion, ...]
    faults: tuple[str, ...]


def read_mpcdi(path: Path) -> MpcdiArchive:
    """Read the projectors of an archive; a UserError if none can be used."""
    with open_input(path) as file:
        try:
            archive = zipfile.ZipFile(file)
        except Exception as fault:  # zipfile raises nearly anything for a damaged file
            raise UserError(f"not a readable zip archive ({fault})", file=path) from fault
        members = {_plain(member.filename): member for member in archive.infolist()}

        def fetch(name: str, most: int) -> bytes | None:
            if (member := members.get(_plain(name))) is None:
                return None
            where = f"{path}: {name!r}"
            try:
                with archive.open(member) as packed:
                    data = packed.read(most + 1)  # the size in its header may be false
            except Exception as fault:  # as above
                raise UserError(f"cannot be unpacked ({fault})", file=where) from fault
            if len(data) > most:
                raise UserError(
                    f"larger than {most // MIB} MiB, expected a smaller file", file=where
                )
            return data

        for name in XML_NAMES:
            if (xml := fetch(name, MAX_XML)) is not None:
                return _archive(parse_xml(xml, f"{path}: {name}"), fetch, str(path))
    raise UserError("no 'mpcdi.xml' in it, expected an MPCDI archive", file=path)


def _plain(name: str) -> str:
    """Make a path in an archive comparable: lower case, forward slashes, no leading ./"""
    return name.strip().replace("\\", "/").removeprefix("./").lower()


def mask(region: MpcdiRegion, gamma: float | Rgb, most: tuple[int, int]) -> NDArray[np.float32]:
    """Factors on red, green and blue code values, and light that is added: (h, w, 4).

    As large as the larger map, but at most `most` pixels. Light is code^gamma. By the standard
    light L becomes A·L + B, with A = a (1 - b) and B = b, here the mean of three colours. So the
    factor on code values is A^(1/gamma).
    """
    shapes = [given.shape for given in (region.alpha, region.beta) if given is not None]
    if not shapes:
        return np.array([[[1.0, 1.0, 1.0, 0.0]]], np.float32)
    height, width, _ = max(shapes, key=lambda shape: shape[0] * shape[1])
    width, height = min(width, most[0]), min(height, most[1])
    factors = np.zeros((height, width, 4), np.float32)
    gammas = np.broadcast_to(gamma, 3)
    alpha, beta = np.ones((1, 1, 3), np.float32), np.zeros((1, 1, 3), np.float32)
    if region.alpha is not None:
        alpha = stretched(region.alpha, width, height)
    if region.beta is not None:
        beta = stretched(region.beta, width, height)
    for k in range(3):  # one after the other: pictures of projectors are large
        a, b = alpha[..., k] ** region.gamma, beta[..., k] ** region.gamma
        factors[..., k] = (a * (1 - b)) ** (1 / gammas[k])
        factors[..., 3] += b / 3
    return factors


def _edges(place: Rect) -> Rect:
    """Left, lower, right and upper edge."""
    x, y, width, height = place
    return x, y, x + width, y + height


def _archive(root: Element, fetch: Fetch, where: str) -> MpcdiArchive:
    """Read all regions; a fault of one leaves the others."""
    profile = root.get("profile", "").strip().lower()
    if root.tag != "mpcdi":
        raise UserError(f"root {root.tag!r} of the XML, expected 'MPCDI'", file=where)
    if profile not in ("2d", "3d"):
        why = PROFILES.get(profile, "")
        raise UserError(f"profile {profile!r}{why}, expected '2d' or '3d'", file=where)
    filesets = {fileset.get("region", ""): fileset for fileset in root.iterfind("files/fileset")}
    regions: dict[str, MpcdiRegion] = {}
    faults: list[str] = []
    elements = [
        (buffer.get("id", ""), element)
        for buffer in root.iterfind("display/buffer")
        for element in buffer.iterfind("region")
    ]
    if not 1 <= len(elements) <= MAX_REGIONS:
        counted = f"{len(elements)} regions in its buffers"
        raise UserError(f"{counted}, expected 1 to {MAX_REGIONS}", file=where)
    pixels = 0
    for buffer, element in elements:
        name = element.get("id", "")
        at = f"{where}: region {name!r}"
        files = {part.tag: part for part in filesets.get(name, ())}
        try:
            if name in regions:
                raise UserError(f"{at}: is there twice, expected names that differ")
            if pixels > MAX_PIXELS:
                raise UserError(f"{at}: maps of those before it have more than {MAX_PIXELS} pixels")
            region = _region(element, buffer, profile, at)
            region = _with_warp(region, files, fetch, at)
        except UserError as fault:
            faults.append(str(fault))
            continue
        for kind in ("alpha", "beta"):
            try:
                region = _with_map(region, kind, files, fetch, at)
            except UserError as fault:
                faults.append(f"{fault}; shown without it")
        unused = [tag for tag, part in files.items() if tag not in USED and _path(part)]
        unused += [part.tag for part in element if part.tag != "frustum"]  # such as a place
        faults.extend(f"{at}: its {tag!r} is not used" for tag in unused)
        regions[name] = region
        maps = [picture for picture in (region.alpha, region.beta) if picture is not None]
        pixels += sum(picture.shape[0] * picture.shape[1] for picture in maps)
    if not regions:
        more = f" (and {len(faults) - 1} more faults)" if len(faults) > 1 else ""
        raise UserError(f"{faults[0]}{more}")
    others = {part.tag for part in root.iterfind("display/buffer/*")} - {"region"}
    faults.extend(f"{where}: {tag!r} of a buffer is not used" for tag in sorted(others))
    lost = sorted(set(filesets) - {element.get("id", "") for _, element in elements})
    faults.extend(f"{where}: files for region {name!r}, which is not there" for name in lost)
    return MpcdiArchive(profile, tuple(regions.values()), tuple(faults))


def _region(element: Element, buffer: str, profile: str, at: str) -> MpcdiRegion:
    """Read the attributes of a region from the XML."""
    width, height = (
        _number(element.get(f"{axis}resolution"), f"{axis}Resolution", at) for axis in "xy"
    )
    if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE):
        raise UserError(f"{at}: {width:g}×{height:g} pixels, expected 1 to {MAX_SIDE} a side")
    x, y, across, up = (_number(element.get(key), key, at) for key in ("x", "y", "xsize", "ysize"))
    left, low, right, high = _edges((x, y, across, up))
    if not (-1e-3 <= left < right <= 1.001 and -1e-3 <= low < high <= 1.001):
        size = f"{across:g}×{up:g} at {x:g}, {y:g}"
        raise UserError(f"{at}: {size} of the buffer, expected shares of it from 0 to 1")
    region = MpcdiRegion(
        element.get("id", ""), buffer, (int(width), int(height)), (x, y, across, up)
    )
    return region._replace(frustum=_frustum(element, at)) if profile == "3d" else region


def _frustum(element: Element, at: str) -> ViewAngles:
    frustum = element.find("frustum")
    if frustum is None:
        raise UserError(f"{at}: no 'frustum', which profile '3d' needs")
    names = ("yaw", "pitch", "roll", "leftAngle", "rightAngle", "downAngle", "upAngle")
    found = ViewAngles(*(_number(frustum.findtext(name.lower()), name, at) for name in names))
    wide = -89 <= found.left_deg < found.right_deg <= 89
    if not (wide and -89 <= found.down_deg < found.up_deg <= 89):
        angles = " ".join(f"{angle:g}" for angle in found[3:])
        raise UserError(f"{at}: left, right, down, up {angles}, expected growing pairs within 89°")
    return found


def _with_warp(
    region: MpcdiRegion, files: Mapping[str, Element], fetch: Fetch, at: str
) -> MpcdiRegion:
    """The region with its warp, if it names one."""
    path = _path(files.get("geometrywarpfile"))
    if not path:
        return region
    at = f"{at}: {path!r}"
    numbers = parse_pfm(_fetched(fetch, path, at), at)
    sources = without_invalid(sources_of(numbers, at))
    left, low, right, high = _edges(region.place)
    points = sources[~np.isnan(sources[..., 0])]
    if len(points) and (left, low, right, high) != (0, 0, 1, 1):
        edges = np.concatenate([points.min(axis=0), points.max(axis=0)])
        if (np.abs(edges - [left, low, right, high]) < AGREES).all():  # shares of the buffer
            sources = (sources - [left, low]) / [right - left, high - low]
    return region._replace(warp=validated(from_grid(sources, region.size), at))


def _with_map(
    region: MpcdiRegion, kind: str, files: Mapping[str, Element], fetch: Fetch, at: str
) -> MpcdiRegion:
    """Add the alpha or beta map of a region, if it names one; alpha's gamma is that of both."""
    element = files.get(f"{kind}map")
    text = element.findtext("gammaembedded") if element is not None and kind == "alpha" else None
    if text is not None:
        gamma = _number(text, "gammaEmbedded", at)
        if not 0.1 <= gamma <= 10:
            raise UserError(f"{at}: gammaEmbedded {gamma:g} of its alpha map, expected 0.1 to 10")
        region = region._replace(gamma=gamma)
    if not (path := _path(element)):
        return region
    at = f"{at}: {path!r}"
    picture = parse_png(_fetched(fetch, path, at), at)
    return region._replace(alpha=picture) if kind == "alpha" else region._replace(beta=picture)


def _path(element: Element | None) -> str:
    """The path in a part of a fileset, or an empty text."""
    return (element.findtext("path") or "").strip() if element is not None else ""


def _fetched(fetch: Fetch, path: str, at: str) -> bytes:
    if (data := fetch(path, MAX_BYTES)) is None:
        raise UserError(f"{at} is not in the archive")
    return data


def _number(text: str | None, name: str, at: str) -> float:
    if text is None:
        raise UserError(f"{at}: {name!r} is missing, expected a number")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UserError(f"{at}: {name} {text.strip()[:40]!r}, expected a number")
    return value
