"""Meshes of what does not move."""

from collections.abc import Sequence

from subsea.core.arrays import Array
from subsea.export.scene import SceneMesh
from subsea.world.world import World


def static_meshes(world: World, groups: Sequence[str], detail: int, eye: Array) -> list[SceneMesh]:
    """T."""
    return []
