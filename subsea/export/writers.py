"""The formats of scenes: `subsea export --to`."""

from collections.abc import Callable

from subsea.base.errors import unknown
from subsea.export.scene import SceneWriter


def _usd() -> SceneWriter:
    from subsea.export.usd_scene import WRITER

    return WRITER


def _gltf() -> SceneWriter:
    from subsea.export.gltf_scene import WRITER

    return WRITER


def _web() -> SceneWriter:
    from subsea.export.web import WRITER

    return WRITER


# Loaded when chosen: each needs other packages.
WRITERS: dict[str, Callable[[], SceneWriter]] = {"usd": _usd, "gltf": _gltf, "web": _web}


def writer_of(target: str) -> SceneWriter:
    """The writer of a target; a UserError lists the targets if it is unknown."""
    if target not in WRITERS:
        raise unknown("target", target, list(WRITERS))
    return WRITERS[target]()
