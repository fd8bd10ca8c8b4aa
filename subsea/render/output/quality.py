"""How much is spent on a picture: presets, and the ladder that a choice by itself climbs.

Every part of the renderer that can do with less reads its own field of `Quality`. The world
never does: what happens in the sea is the same at every quality.
"""

from dataclasses import dataclass, replace

from subsea.core.errors import unknown

AUTO = "auto"
SOFTWARE = ("llvmpipe", "softpipe", "swrast")  # renderers without a GPU
SMALLEST_SCALE, SCALE_STEP = 0.5, 0.05


@dataclass(frozen=True)
class Quality:
    """What each part of a picture may cost. `adapt(quality)` of a part takes it at any time."""

    # Pixels of the canvas per pixel of the picture, along each side, in [0.25, 2]. `renderer.py`;
    # of a display for two eyes or all round the canvas is always exact.
    scale: float = 1.0
    # Samples per pixel of the canvas that smooth the edges of triangles; 0 none. `target.py`.
    samples: int = 0
    # Whether edges are smoothed in the finished picture, by their contrast. `target.py`.
    smooth: bool = True
    # Factor on the pixels that anything is taken to cover when its level of detail is chosen:
    # larger is finer. `frame.pack` for fishes and seaweed, `standing.py` for what stands still.
    detail: float = 1.0
    # Share of corals and of clusters of seaweed that is drawn, in [0, 1]. `coral.py`, `frame.pack`.
    growth: float = 1.0
    # Specks of marine snow in the box about the eye. `particles.py`.
    snow: int = 1400
    # Places where light enters that each shaft is made of; 0 no shafts. `shafts.py`.
    shafts: int = 8
    # Whether corals, fishes and the submarine darken the sand beneath. `coral.py`, `blobs.py`.
    shadows: bool = True


PRESETS = {
    "low": Quality(smooth=False, detail=0.7, growth=0.6, snow=700, shafts=6),
    "medium": Quality(),
    "high": Quality(samples=4, detail=1.6, snow=2400, shafts=16),
}
CHOICES = (AUTO, *PRESETS)

# What `auto` chooses among, cheapest first: the lowest preset on a smaller and smaller canvas,
# then the presets in full. Neighbours differ so little in the first part that nobody sees a step.
LADDER = (
    *(
        replace(PRESETS["low"], scale=round(SMALLEST_SCALE + k * SCALE_STEP, 2))
        for k in range(round((1.0 - SMALLEST_SCALE) / SCALE_STEP))
    ),
    *PRESETS.values(),
)


def check_choice(name: str) -> str:
    """The name of a preset, or "auto"; any other is a UserError."""
    if name not in CHOICES:
        raise unknown("quality", name, list(CHOICES))
    return name


def name_of(quality: Quality) -> str:
    """The preset that a quality is, with the scale of its canvas if that is not 1."""
    full = replace(quality, scale=1.0)
    name = next((name for name, preset in PRESETS.items() if preset == full), "own")
    return name if quality.scale == 1.0 else f"{name} at {quality.scale:.0%}"


def on_software(renderer: str) -> bool:
    """Whether the `GL_RENDERER` of a context computes its pictures without a GPU."""
    return any(name in renderer.lower() for name in SOFTWARE)


def first_rung(renderer: str) -> int:
    """Where on the LADDER a choice by itself begins: low without a GPU, high with one."""
    return LADDER.index(PRESETS["low" if on_software(renderer) else "high"])
