"""Build ready-made models of all species and two scenes, with pictures and an index page.

.venv/bin/python tools/make_gallery.py [--out FOLDER] [--only NAME ...] [--detail N]

`make gallery` does this. What is up to date is skipped: an interrupted run goes on where it was.
"""

import argparse
import hashlib
import html
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "docs"))

from make_pictures import species_plate  # noqa: E402

from subsea import __version__  # noqa: E402
from subsea.base.errors import UserError, unknown  # noqa: E402
from subsea.base.files import check_folder, replacing  # noqa: E402
from subsea.base.progress import progress, say  # noqa: E402
from subsea.base.source_stamp import source_stamp  # noqa: E402
from subsea.base.system import require  # noqa: E402
from subsea.export.clips import all_points, make_clips  # noqa: E402
from subsea.export.conventions import HOLDER, SENTENCE  # noqa: E402
from subsea.export.gltf import write_gltf  # noqa: E402
from subsea.export.gltf_scene import WRITER as GLTF  # noqa: E402
from subsea.export.options import SceneOptions  # noqa: E402
from subsea.export.recording import SceneFilmOptions, record_scene  # noqa: E402
from subsea.export.skinning import fit_skeleton  # noqa: E402
from subsea.export.usd import write_package, write_usd  # noqa: E402
from subsea.export.usd_scene import WRITER as USD  # noqa: E402
from subsea.fish.species import load_species, repertoire_file, shipped_species, species_file  # noqa: E402
from subsea.scenario.load import load_scenario  # noqa: E402

POSES = 40  # of a species in the USD package of a scene
PICTURE = (960, 540)
QUALITY = 82  # of JPEG
STYLE = """
:root { color-scheme: light dark; font: 1rem/1.5 system-ui, sans-serif; }
body { max-width: 72rem; margin: 0 auto; padding: 1rem; }
ul.models { display: grid; grid-template-columns: repeat(auto-fill, minmax(20rem, 1fr));
  gap: 1.5rem; list-style: none; padding: 0; }
img { width: 100%; height: auto; border-radius: 0.4rem; }
h3 { margin: 0.4rem 0 0; }
p { margin: 0.3rem 0; }
a { padding: 0.2rem 0; }
a:focus-visible { outline: 0.2rem solid; }
"""
PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Fishes and reefs of subsea</title>
<style>{style}</style>
</head>
<body>
<main>
<h1>Fishes and reefs of subsea</h1>
<p>Models with their motion, for Blender, Unity, Unreal, Godot and web pages. Lengths are metres, y
is up, a fish heads along +z.</p>
{models}
<h2>May I sell it?</h2>
<p>Yes. {holder}. <a href="LICENSE.txt">{licence}</a></p>
</main>
</body>
</html>
"""


class Scene(NamedTuple):
    """A scene of the gallery."""

    scenario: str
    start: float  # s
    seconds: float
    says: str


SCENES = (
    Scene("peaceful", 6.0, 3.0, "A reef with its fishes, from a submarine that drifts through it"),
    Scene("schooling", 4.0, 3.0, "A school of fusiliers around a pillar"),
)
FPS = 24.0


class Item(NamedTuple):
    """A model of the gallery."""

    name: str
    title: str
    says: str
    scene: Scene | None  # None: a species


def items(only: list[str]) -> list[Item]:
    """List all models, or those with the names `only`."""
    species = [
        Item(name, one.name, f"{one.size_cm[0]:g} to {one.size_cm[1]:g} cm long", None)
        for name in shipped_species()
        for one in [load_species(name)]
    ]
    scenes = [
        Item(one.scenario, load_scenario(one.scenario)[0].title, one.says, one) for one in SCENES
    ]
    every = species + scenes
    for name in only:
        if name not in (known := [item.name for item in every]):
            raise unknown("model", name, known)
    return [item for item in every if not only or item.name in only]


def stamp(item: Item, detail: int) -> str:
    """Hash all that a model is made from."""
    sha = hashlib.sha256(source_stamp(Path(__file__).resolve()).encode())
    sources = [ROOT / "docs" / "make_pictures.py"]
    if item.scene is None:
        sources += [species_file(item.name), repertoire_file(item.name)]
    else:
        scenario, source, _ = load_scenario(item.name)
        sources.append(source)
        for name in scenario.species:
            sources += [species_file(name), repertoire_file(name)]
    for path in sources:
        sha.update(path.read_bytes())
    sha.update(f"{detail} {item.scene} {FPS} {POSES} {__version__}".encode())
    return sha.hexdigest()


def make_species(folder: Path, name: str, detail: int) -> None:
    """Write the models and the picture of a species."""
    model, clips = make_clips(name, detail)
    write_gltf(folder, model, clips, False, fit_skeleton(model, all_points(clips)))

    def fill(inside: Path) -> Path:
        return write_usd(inside, model, clips, False)[0]

    write_package(folder / f"{name}.usdz", fill)
    save(species_plate([name]), folder / f"{name}.jpg")


def make_scene(folder: Path, one: Scene, detail: int) -> None:
    """Write the models and the picture of a scene: its first frame."""
    film = SceneFilmOptions(
        out=folder / f"{one.scenario}.glb", loaded=load_scenario(one.scenario), start=one.start,
        seconds=one.seconds, fps=FPS, size=PICTURE, detail=detail,
    )  # fmt: skip
    scene = record_scene(film)
    GLTF.write(scene, film.out, SceneOptions(force=True))
    USD.write(scene, film.out.with_suffix(".usdz"), SceneOptions(force=True, poses=POSES))
    shot = folder / f".{one.scenario}.png"
    size = f"{PICTURE[0]}x{PICTURE[1]}"
    subprocess.run(
        [
            sys.executable, "-m", "subsea", "film", str(shot), "--scenario", one.scenario,
            "--start", str(one.start), "--seconds", "0.05", "--fps", str(FPS), "--size", size,
            "--force",
        ],
        check=True,
        cwd=ROOT,
    )  # fmt: skip
    with Image.open(shot) as picture:
        save(picture.convert("RGB"), folder / f"{one.scenario}.jpg")
    shot.unlink()


def save(picture: Image.Image, path: Path) -> None:
    """Write a JPEG file as a whole."""
    with replacing(path) as part:
        picture.convert("RGB").save(part, "JPEG", quality=QUALITY, optimize=True)


def files_of(name: str) -> list[str]:
    """Name the files of a model."""
    return [f"{name}.glb", f"{name}.usdz", f"{name}.jpg"]


def is_current(folder: Path, name: str, wanted: str) -> bool:
    """Check that the files of a model are there, and were made from what the stamp says."""
    stamp_file = folder / f".{name}.stamp"
    there = all((folder / file).is_file() for file in files_of(name))
    return there and stamp_file.is_file() and stamp_file.read_text(encoding="utf-8") == wanted


def write_text(path: Path, text: str) -> None:
    """Write a file as a whole."""
    with replacing(path) as part:
        part.write_text(text, encoding="utf-8")


def index_page(folder: Path, made: list[Item]) -> str:
    """Write the page of all models that are there."""
    scenes = [item for item in made if item.scene is not None]
    species = [item for item in made if item.scene is None]
    parts = [*_section("Species", species, folder), *_section("Scenes", scenes, folder)]
    licence = html.escape(SENTENCE)
    return PAGE.format(
        style=STYLE, models="\n".join(parts), holder=html.escape(HOLDER), licence=licence
    )


def _section(title: str, chosen: list[Item], folder: Path) -> Iterator[str]:
    if not chosen:
        return
    yield f"<h2>{title}</h2>"
    yield '<ul class="models">'
    for item in chosen:
        with Image.open(folder / f"{item.name}.jpg") as picture:
            width, height = picture.size
        name, says = html.escape(item.title), html.escape(item.says)
        yield "<li>"
        yield (
            f'<img src="{item.name}.jpg" width="{width}" height="{height}" loading="lazy" '
            f'alt="{name}: {says}">'
        )
        yield f"<h3>{name}</h3>"
        yield f"<p>{says}</p>"
        links = []
        for kind, noun in (("glb", "glTF"), ("usdz", "USD")):
            file = folder / f"{item.name}.{kind}"
            size = f"{file.stat().st_size / 1e6:.1f} MB"
            links.append(f'<a href="{file.name}" download>{name} as {noun} (.{kind}, {size})</a>')
        yield f"<p>{'<br>'.join(links)}</p>"
        yield "</li>"
    yield "</ul>"


def build(folder: Path, only: list[str], detail: int) -> int:
    """Make what is missing; returns how many models were made."""
    require("usd", "the gallery")
    folder.mkdir(parents=True, exist_ok=True)
    check_folder(folder)
    chosen = items(only)
    stamps = {item.name: stamp(item, detail) for item in chosen}
    missing = [item for item in chosen if not is_current(folder, item.name, stamps[item.name])]
    say(f"{len(missing)} of {len(chosen)} models to make, the others are up to date")
    with progress(len(chosen), "model", len(chosen) - len(missing)) as done:
        for item in missing:
            say(f"making {item.name}")
            if item.scene is None:
                make_species(folder, item.name, detail)
            else:
                make_scene(folder, item.scene, detail)
            write_text(folder / f".{item.name}.stamp", stamps[item.name])
            done()
    write_text(folder / "LICENSE.txt", (ROOT / "LICENSE").read_text(encoding="utf-8"))
    there = [
        item for item in items([]) if all((folder / file).is_file() for file in files_of(item.name))
    ]
    write_text(folder / "index.html", index_page(folder, there))
    return len(missing)


def main() -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "gallery", metavar="FOLDER")
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME")
    parser.add_argument("--detail", type=int, choices=range(4), default=1, metavar="N")
    options = parser.parse_args()
    try:
        build(options.out, options.only, options.detail)
    except UserError as fault:
        print(f"make_gallery: {fault}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("make_gallery: interrupted; the next run goes on here", file=sys.stderr)
        return 130
    print(options.out / "index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
