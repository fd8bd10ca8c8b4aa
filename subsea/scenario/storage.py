"""Save scenarios without overwriting shipped ones, and their small pictures for the menu."""

import warnings
from io import BytesIO
from pathlib import Path

import numpy as np

from subsea.base.arrays import Bytes
from subsea.base.errors import UserError
from subsea.base.files import MIB, check_file, read_input
from subsea.base.pictures import in_srgb
from subsea.base.system import resource_names, resource_path
from subsea.scenario.load import (
    SHIPPED,
    LoadedScenario,
    load_scenario,
    own_scenarios,
    scenario_names,
)
from subsea.scenario.save import save_scenario
from subsea.scenario.schema import Scenario

SIZE = 480, 270  # larger pictures are scaled down
MOST_PIXELS = 16_000_000


def read_thumbnail(scenario: Path) -> Bytes | None:
    """The picture (h, w, 3) beside a scenario file, top row first; None without a good one."""
    from PIL import Image, ImageOps

    try:
        data = read_input(scenario.with_suffix(".jpg"), MIB)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the number of pixels is checked below
            with Image.open(BytesIO(data), formats=("JPEG",)) as image:
                if image.width * image.height > MOST_PIXELS:
                    return None
                image.thumbnail(SIZE)
                ImageOps.exif_transpose(image, in_place=True)
                return np.asarray(in_srgb(image))
    except Exception:  # Pillow's readers raise any exception for damaged files
        return None


def is_shipped(path: Path) -> bool:
    """True if a file comes with the program."""
    return path.resolve().parent == resource_path(SHIPPED).resolve()


def place_of(source: Path) -> Path:
    """The path to save a scenario to: its own, or ``my-NAME`` if it is shipped."""
    if not is_shipped(source):
        return source
    number, path = 1, own_scenarios() / f"my-{source.name}"
    while _is_there(path):
        number += 1
        path = path.with_name(f"my-{source.stem}-{number}.toml")
    return path


def place_named(name: str) -> Path:
    """The unused path for a scenario of this name, in the user's own folder, or for this path."""
    if not name or name.endswith(("/", "\\")):
        raise UserError(f"{name or 'nothing'}: expected a name to save the scenario as")
    if "/" in name or "\\" in name:
        path = _path(name).absolute()
        path = path if path.suffix == ".toml" else path.with_name(f"{path.name}.toml")
    else:
        path = own_scenarios() / f"{name.removesuffix('.toml')}.toml"
    if path.stem in resource_names(SHIPPED, ".toml") and path.parent == own_scenarios():
        raise UserError(f"the name {path.stem!r} is that of a shipped scenario, expected another")
    if _is_there(path):
        raise UserError("exists; choose another name", file=path)
    return path


def held(path: Path) -> bytes:
    """The content of a file; empty if it cannot be read."""
    try:
        return read_input(path)
    except UserError:
        return b""


def save(scenario: Scenario, path: Path, source: Path, known: bytes) -> None:
    """Write the scenario of the file `source`, whose last known content is `known`, to `path`.

    UserError if it cannot be written or another program has changed the file.
    """
    if is_shipped(path):
        raise UserError("comes with the program, expected another place", file=path)
    if path == source and held(path) not in (known, b""):
        raise UserError(
            "was changed by another program, expected another name, or that it is opened again",
            file=path,
        )
    check_file(path)
    save_scenario(scenario, path, source)


def opened(name: str) -> LoadedScenario:
    """Load a scenario by name or path, in which ``~`` is expanded."""
    return load_scenario(name if name in scenario_names() else str(_path(name)))


def _path(text: str) -> Path:
    """Expand ``~`` in a path; a UserError for an unknown user."""
    try:
        return Path(text).expanduser()
    except RuntimeError as fault:
        raise UserError(f"{text}: there is no such user") from fault


def _is_there(path: Path) -> bool:
    """True if a path exists; a UserError for an impossible name."""
    try:
        return path.exists()
    except OSError as fault:
        raise UserError(f"{fault.strerror}", file=path) from fault
