"""A measure of records: how deep fishes are."""

from subsea.base.arrays import Array


def depth_cm(position: Array) -> dict[str, float]:
    """Measure the least and the greatest depth, cm."""
    return {"least": -position[..., 2].max(), "most": -position[..., 2].min()}
