"""A folder with a page that shows an exported scene, for any static web server.

The page draws `scene.glb` with three.js, which is no part of this project: the file
`assets/web/package.json` declares it, and the folder gets its modules and its licence. The dive's
own shader code computes the light in the water (`shaders/optics.glsl`), with the values that
`rendering.output.daylight` gives for the scenario.
"""

import base64
import hashlib
import html
import json
import re
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from subsea.core.atomic_io import replacing
from subsea.core.errors import UserError
from subsea.core.resources import own_path, resource_path
from subsea.export.web_words import WORDS, words_by_language
from subsea.rendering.gl.shaders import source
from subsea.rendering.gl.textures import near_and_far
from subsea.rendering.output.daylight import light_uniforms
from subsea.rendering.output.uniforms import TIDE_S
from subsea.scenario.schema import Water

SCENE = "scene.glb"
PAGE = ("viewer.js", "viewer.css", "water.js", "flight.js", "fishes.js", "icon.svg")
# Of three.js: what the page imports, and what that imports.
THREE = (
    "build/three.module.js", "build/three.core.js",
    "examples/jsm/loaders/GLTFLoader.js", "examples/jsm/controls/OrbitControls.js",
    "examples/jsm/utils/BufferGeometryUtils.js", "examples/jsm/utils/SkeletonUtils.js",
    "LICENSE", "package.json",
)  # fmt: skip
MODULES = {
    "imports": {
        "three": "./three/build/three.module.js",
        "three/addons/": "./three/examples/jsm/",
    }
}
POLICY = (
    "default-src 'none'; script-src 'self' '{digest}'; style-src 'self'; img-src 'self' blob:; "
    "connect-src 'self' blob:; base-uri 'none'; form-action 'none'"
)
STEP_CM, DEPTH_CM = 50.0, 5000.0  # of the table of the eye's light
# The dive's axes (x, y, z up) in those of the page (y up), as rows.
AXES = ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0))


class WebFish(NamedTuple):
    """A fish of the list."""

    node: str  # of the glTF file
    species: int  # its place among the species
    number: int  # within its species, from 1
    length_cm: float
    first: int  # frames in which it is in the sea
    last: int


class WebScene(NamedTuple):
    """What the page tells of a scene beside its glTF file."""

    title: str
    frames: int
    fps: float
    start_s: float  # of the dive, when the scene begins
    species: Sequence[tuple[str, str]]  # name and scientific name
    fishes: Sequence[WebFish]
    captions: Sequence[tuple[float, float, str]]  # from, to (s since the scene begins), words
    water: Water
    licence: str


def write_web(folder: Path, scene: WebScene, write_glb: Callable[[Path], object]) -> list[Path]:
    """Write the page into a folder; return its files. `write_glb` writes the scene to a path.

    All files appear at the end, or none. UserError if three.js is missing or a file cannot be
    written.
    """
    three = find_three()
    fixed = {name: resource_path(f"assets/web/{name}").read_bytes() for name in PAGE}
    fixed |= {f"three/{name}": (three / name).read_bytes() for name in THREE}
    fixed["index.html"] = _index(scene).encode()
    fixed["water.glsl"] = water_code().encode()
    fixed["caustics.bin"] = near_and_far(0).astype("<f2").tobytes()
    with ExitStack() as stack:
        glb = stack.enter_context(replacing(folder / SCENE))
        write_glb(glb)
        fixed["scene.json"] = json.dumps(
            _about(scene, glb.stat().st_size), ensure_ascii=False, separators=(",", ":")
        ).encode()
        for name, data in fixed.items():
            stack.enter_context(replacing(folder / name)).write_bytes(data)
    return [folder / name for name in (SCENE, *fixed)]


def find_three() -> Path:
    """The folder of three.js in the version that the page is written for.

    UserError with the command that installs it if it is missing.
    """
    wanted = json.loads(resource_path("assets/web/package.json").read_text("utf-8"))
    version = wanted["dependencies"]["three"]
    own = own_path("web")
    for place in (Path(sys.prefix) / "web", own):
        folder = place / "node_modules" / "three"
        try:
            if json.loads((folder / "package.json").read_text("utf-8"))["version"] == version:
                return folder
        except (OSError, ValueError, KeyError, TypeError):
            continue
    raise UserError(
        f"the page needs three.js {version}; type "
        f"`npm install --ignore-scripts --prefix {shlex.quote(str(own))} three@{version}`"
    )


def water_code() -> str:
    """The shader code of light in water, with the curve from light to the screen."""
    lines = source("optics.glsl").splitlines()
    optics = "\n".join(line for line in lines if not line.startswith(("#version", "#line")))
    [curve] = re.findall(
        r"^vec3 filmic\(vec3 x\) \{$.*?^\}$", source("resolve.frag"), re.MULTILINE | re.DOTALL
    )
    return f"{optics}\n{curve}\n"


def _index(scene: WebScene) -> str:
    """The page, with the digest of its only inline script, the map of modules."""
    modules = json.dumps(MODULES)
    digest = base64.b64encode(hashlib.sha256(modules.encode()).digest()).decode()
    words: Mapping[str, str] = WORDS | {
        "title": scene.title,
        "licence": scene.licence,
        "policy": POLICY.format(digest=f"sha256-{digest}"),
    }
    page = resource_path("assets/web/index.html").read_text("utf-8").replace("{{modules}}", modules)
    return re.sub(r"\{\{(\w+)\}\}", lambda one: html.escape(words[one[1]]), page)


def _about(scene: WebScene, size: int) -> dict[str, Any]:
    """The contents of scene.json."""
    depths = np.arange(0.0, DEPTH_CM + STEP_CM, STEP_CM)
    rows = [light_uniforms(scene.water, (0.0, 0.0, -depth)) for depth in depths]
    changing = [name for name in rows[0] if rows[0][name] != rows[-1][name]]
    return {
        "title": scene.title,
        "file": SCENE,
        "bytes": size,
        "frames": scene.frames,
        "fps": scene.fps,
        "start_s": scene.start_s,
        "licence": scene.licence,
        "species": [{"title": name, "scientific": latin} for name, latin in scene.species],
        "fishes": [fish._asdict() for fish in scene.fishes],
        "captions": [{"from_s": a, "to_s": b, "text": text} for a, b, text in scene.captions],
        "water": {
            "axes": AXES,
            "tide_s": TIDE_S,
            "step_cm": STEP_CM,
            "steady": {name: rows[0][name] for name in rows[0] if name not in changing},
            "by_depth": {
                name: [np.round(row[name], 6).tolist() for row in rows] for name in changing
            },
        },
        "words": words_by_language(),
    }
