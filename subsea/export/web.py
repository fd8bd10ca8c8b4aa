"""Write a folder with a page that shows an exported scene, for any static web server.

The page draws `scene.glb` with three.js, which lies outside this project: the file
`assets/web/package.json` declares it, and the folder gets its modules and its licence. The dive's
own shader code computes the light in the water (`shaders/optics.glsl`), with the values that
`rendering.output.uniforms` gives for the scenario.

`WORDS` has all words of the page in English. They replace `{{name}}` in `assets/web/index.html`;
`scene.json` has them in all languages for the script.
"""

import base64
import hashlib
import html
import json
import re
import shlex
import sys
from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.errors import UserError
from subsea.base.files import check_folder, is_folder, replacing
from subsea.base.language import LANGUAGES, translated
from subsea.base.system import own_path, resource_path
from subsea.export import MESHOPT, PLAIN, QUANTISED
from subsea.export.conventions import WORLD_Y_UP, copyright_line
from subsea.export.gltf_scene import WRITER as GLTF
from subsea.export.options import SceneOptions
from subsea.export.scene import Scene, SceneExtent, SceneWriter
from subsea.fish.species import load_species
from subsea.rendering.gl.shaders import source
from subsea.rendering.gl.textures import near_and_far
from subsea.rendering.output.target import gain
from subsea.rendering.output.uniforms import TIDE_S, light_uniforms
from subsea.rendering.reef.rocks import roughness
from subsea.scenario.schema import Grade, Water

WORDS = {
    "skip": "Skip to the list of fishes",
    "sea": "The sea",
    "loading": "Loading the sea …",
    "loaded": "Loaded",
    "script": "This page needs JavaScript.",
    "webgl": "This browser or its settings do not allow WebGL 2, with which the sea is drawn. "
    "The file can still be downloaded.",
    "lost": "The graphics driver has stopped. Load the page again.",
    "failed": "The scene could not be loaded.",
    "fishes": "Fishes",
    "play": "Play",
    "pause": "Pause",
    "time": "Time",
    "view": "View",
    "film": "As filmed",
    "orbit": "Around a place",
    "fly": "Fly",
    "about": "Help and licence",
    "help": "Drag to look around, scroll or pinch to go nearer. Keys: arrows turn, W and S go "
    "ahead and back, A and D aside, E and Q up and down, space plays, Escape lets a fish go.",
    "download": "Download the scene (glTF, {size} MB)",
}


def words_by_language(names: Iterable[str] = ()) -> dict[str, dict[str, Any]]:
    """Translate all words, and `names` of the scene and its species, to each language."""
    known = tuple(names)
    return {
        code: {name: translated(text, code) for name, text in WORDS.items()}
        | {"names": {name: translated(name, code) for name in known}}
        for code in LANGUAGES
    }


SCENE, ABOUT = "scene.glb", "scene.json"
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
CAUSTICS_SEED, RELIEF_SEED = 1, 5  # of dancing light and the relief of stone, as in the dive
PAGE_BYTES = 3_000_000  # of the page and three.js
GRADE = "u_gain", "u_contrast", "u_saturation"  # uniforms of `shaders/curve.glsl`
STEP_CM, DEPTH_CM = 50.0, 5000.0  # of the table of the eye's light


def _check(out: Path, options: SceneOptions) -> None:
    """Refuse options of other formats, a missing three.js, and a folder of other files."""
    for name, given in (
        ("poses", options.poses is not None),
        ("morph", options.morph),
        ("vat", options.vat),
        ("compress meshopt", options.compress == MESHOPT),
    ):
        if given:
            raise UserError(f"--{name} is not for --to web")
    find_three()
    if out.exists() and not is_folder(out):
        raise UserError("is a file, expected a folder", file=out)
    check_folder(out)
    if out.is_dir() and any(out.iterdir()) and not (out / ABOUT).is_file() and not options.force:
        raise UserError("holds other files; give --force to write among them", file=out)
    GLTF.check(out / SCENE, _packed(options))


def _estimate(extent: SceneExtent, options: SceneOptions) -> int:
    """Estimate the bytes of the fishes and of the page."""
    return GLTF.estimate(extent, _packed(options)) + PAGE_BYTES


def _packed(options: SceneOptions) -> SceneOptions:
    """Choose the options of the glTF file: small, and copies as instances, which draw faster."""
    packed = QUANTISED if options.compress == PLAIN else options.compress
    return replace(options, compress=packed, instances=True, force=True)


def _write(scene: Scene, out: Path, options: SceneOptions) -> list[Path]:
    """Write the page of a scene into a folder; return its files.

    All files appear at the end, or none. UserError if a file cannot be written.
    """
    three = find_three()
    files = {name: resource_path(f"assets/web/{name}").read_bytes() for name in PAGE}
    files |= {f"three/{name}": (three / name).read_bytes() for name in THREE}
    files["index.html"] = _index(scene).encode()
    files["water.glsl"] = water_code().encode()
    files["shafts.glsl"] = _plain(source("shafts.frag", PAGE=1)).encode()
    files["caustics.bin"] = near_and_far(CAUSTICS_SEED).astype("<f2").tobytes()
    files["relief.bin"] = roughness(RELIEF_SEED).tobytes()
    with ExitStack() as stack:
        glb = stack.enter_context(replacing(out / SCENE))
        GLTF.write(scene, glb, _packed(options))
        about = _about(scene, glb.stat().st_size)
        files[ABOUT] = json.dumps(about, ensure_ascii=False, separators=(",", ":")).encode()
        for name, data in files.items():
            stack.enter_context(replacing(out / name)).write_bytes(data)
    return [out / name for name in (SCENE, *files)]


def find_three() -> Path:
    """Find the folder of three.js in the version that the page is written for.

    UserError with the command that installs it if it is missing.
    """
    wanted = json.loads(resource_path("assets/web/package.json").read_text("utf-8"))
    version = wanted["dependencies"]["three"]
    users = own_path("web")
    for place in (Path(sys.prefix) / "web", users):
        folder = place / "node_modules" / "three"
        try:
            if json.loads((folder / "package.json").read_text("utf-8"))["version"] == version:
                return folder
        except (OSError, ValueError, KeyError, TypeError):
            continue
    raise UserError(
        f"the page needs three.js {version}; type "
        f"`npm install --ignore-scripts --prefix {shlex.quote(str(users))} three@{version}`"
    )


def water_code() -> str:
    """Return the shader code of light in water, of sway and stone, and from light to the screen."""
    code = source("optics.glsl", PAGE=1) + source("fish_light.glsl")
    code += source("sway.glsl") + source("relief.glsl")
    return _plain(code + source("curve.glsl", GRADED=1, LINEAR=1))


def _plain(code: str) -> str:
    """Return shader code without what a browser sets or does not know."""
    lines = code.splitlines(keepends=True)
    return "".join(line for line in lines if not line.startswith(("#version", "#line")))


def _index(scene: Scene) -> str:
    """Fill in the page, with the digest of its only inline script, the map of modules."""
    modules = json.dumps(MODULES)
    digest = base64.b64encode(hashlib.sha256(modules.encode()).digest()).decode()
    words = WORDS | {
        "title": scene.title,
        "licence": _licence(scene),
        "policy": POLICY.format(digest=f"sha256-{digest}"),
    }
    page = resource_path("assets/web/index.html").read_text("utf-8").replace("{{modules}}", modules)
    return re.sub(r"\{\{(\w+)\}\}", lambda match: html.escape(words[match[1]]), page)


def _licence(scene: Scene) -> str:
    return copyright_line(model.name for model in scene.models)


def _about(scene: Scene, size: int) -> dict[str, Any]:
    """Collect the contents of scene.json; `size` is the size of the glTF file in bytes."""
    species = [load_species(model.name) for model in scene.models]
    return {
        "title": scene.title,
        "file": SCENE,
        "bytes": size,
        "frames": scene.frames,
        "loop": scene.seamless,
        "fps": scene.fps,
        "start_s": scene.start_s,
        "cuts": scene.camera.cuts,
        "licence": _licence(scene),
        "species": [{"title": kind.name, "scientific": kind.scientific_name} for kind in species],
        "fishes": [
            {
                "node": fish.name,
                "species": fish.model,
                "number": int(fish.name.rpartition("_")[2]) + 1,
                "length_cm": round(fish.length_cm, 1),
                "first": fish.first,
                "last": fish.last,
            }
            for fish in scene.fishes
        ],
        "captions": _captions(scene),
        "water": _water(scene.water, scene.grade),
        "words": words_by_language([scene.title, *(kind.name for kind in species)]),
    }


def _captions(scene: Scene) -> list[dict[str, Any]]:
    """List each caption with its first and last frame."""
    captions: list[dict[str, Any]] = []
    for frame, text in enumerate(scene.captions):
        if captions and captions[-1]["last"] == frame - 1 and captions[-1]["text"] == text:
            captions[-1]["last"] = frame
        elif text:
            captions.append({"first": frame, "last": frame, "text": text})
    return captions


def _water(water: Water, grade: Grade) -> dict[str, Any]:
    """Compute the uniforms of the water; some depend on the eye, in steps of its depth."""
    depths = np.arange(0.0, DEPTH_CM + STEP_CM, STEP_CM)
    rows = [light_uniforms(water, (0.0, 0.0, -depth)) for depth in depths]
    changing = [name for name in rows[0] if rows[0][name] != rows[-1][name]]
    return {
        "axes": WORLD_Y_UP.T.tolist(),
        "tide_s": TIDE_S,
        "step_cm": STEP_CM,
        "steady": dict(zip(GRADE, (gain(grade), grade.contrast, grade.saturation), strict=True))
        | {name: value for name, value in rows[0].items() if name not in changing},
        "by_depth": {name: [np.round(row[name], 6).tolist() for row in rows] for name in changing},
    }


WRITER = SceneWriter(_check, _estimate, _write)
