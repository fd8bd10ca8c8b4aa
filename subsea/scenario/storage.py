"""Where a dive's scenario is saved, as it is now: never over one that comes with the program."""

from pathlib import Path

from subsea.core.atomic_io import check_file
from subsea.core.errors import UserError
from subsea.core.resources import resource_names, resource_path
from subsea.scenario.load import SHIPPED, load_scenario, own_scenarios, scenario_names
from subsea.scenario.save import save_scenario
from subsea.scenario.schema import Scenario


def is_shipped(path: Path) -> bool:
    """Whether this file came with the program."""
    return path.resolve().parent == resource_path(SHIPPED).resolve()


def place_of(source: Path) -> Path:
    """Where the scenario of a file is saved: there, or as ``my-NAME`` if it came along."""
    if not is_shipped(source):
        return source
    number, path = 1, own_scenarios() / f"my-{source.name}"
    while _is_there(path):
        number += 1
        path = path.with_name(f"my-{source.stem}-{number}.toml")
    return path


def place_named(name: str) -> Path:
    """Where a scenario is saved under a name, or at a path: nothing may be there.

    A word is a name in the visitor's own folder.
    """
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
        raise UserError("is there already, expected another name", file=path)
    return path


def held(path: Path) -> bytes:
    """What a file holds; nothing where there is none."""
    try:
        return path.read_bytes()
    except OSError:
        return b""


def save(scenario: Scenario, path: Path, source: Path, known: bytes) -> None:
    """Write the scenario of the file `source`, which held `known`, to `path`.

    What cannot be written is a UserError, and so is what another has changed since.
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


def opened(name: str) -> tuple[Scenario, Path]:
    """The scenario of a name or at a path, and its file."""
    return load_scenario(name if name in scenario_names() else str(_path(name)))


def _path(text: str) -> Path:
    """The path that somebody has written; a ``~`` of nobody known is a UserError."""
    try:
        return Path(text).expanduser()
    except RuntimeError as fault:
        raise UserError(f"{text}: there is no such user") from fault


def _is_there(path: Path) -> bool:
    """Whether something is at a path; a name that no file can have is a UserError."""
    try:
        return path.exists()
    except OSError as fault:
        raise UserError(f"{fault.strerror}", file=path) from fault
