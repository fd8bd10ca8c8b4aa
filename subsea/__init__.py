"""A virtual submarine among artificial fishes, and their sea as a library.

>>> import subsea
>>> world = subsea.load("peaceful", seed=1, fish=10)
>>> world.step(30)
>>> world.fishes.position.shape
(10, 3)
"""

from importlib import import_module as _import_module
from typing import Any as _Any

__version__ = "0.2.0"

_PLACES = {
    "load": "subsea.library",
    "World": "subsea.library",
    "Helm": "subsea.submarine.vessel",
    "TeleopCommand": "subsea.behavior.teleop",
    "TeleopCommands": "subsea.behavior.teleop",
    "render": "subsea.library",
    "camera": "subsea.library",
    "behind": "subsea.library",
    "retina": "subsea.library",
    "Retina": "subsea.library",
    "labels": "subsea.lab.dataset.labelling",
    "Labels": "subsea.lab.dataset.labelling",
    "CameraLens": "subsea.view.optics",
    "FlatPort": "subsea.view.optics",
    "simulate": "subsea.lab.records",
    "sweep": "subsea.lab.records",
    "latin_hypercube": "subsea.lab.designs",
    "sobol": "subsea.lab.designs",
    "open_record": "subsea.lab.records",
    "measure": "subsea.lab.records",
    "record": "subsea.lab.records",
    "rule": "subsea.lab.rules",
    "sense": "subsea.lab.rules",
    "Record": "subsea.media.record",
    "scenarios": "subsea.lab.records",
    "species": "subsea.lab.records",
    "school": "subsea.lab.environments.school",
    "predator_prey": "subsea.lab.environments.predator_prey",
    "UserError": "subsea.base.errors",
}
"""The public names and their modules, loaded at first use. `__init__.pyi` has their types."""

__all__ = ["__version__", *_PLACES]


def __getattr__(name: str) -> _Any:
    """Load a public name."""
    if name not in _PLACES:
        raise AttributeError(f"module 'subsea' has no attribute {name!r}")
    module = _import_module(_PLACES[name])
    found = module if _PLACES[name].endswith(f".{name}") else getattr(module, name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
