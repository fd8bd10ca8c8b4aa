"""Rendering quality: presets, and the ladder for automatic choice.

Each part of the renderer reads its own field of `Quality`. The world never does, so what happens in
the sea is the same at every quality.
"""

from dataclasses import dataclass, replace

from subsea.base.errors import unknown
from subsea.frame.packet import PackOptions

AUTO = "auto"
SOFTWARE = ("llvmpipe", "softpipe", "swrast")  # renderers without a GPU
SMALLEST_SCALE, SCALE_STEP = 0.5, 0.05


@dataclass(frozen=True)
class Quality:
    """Cost limits for each part of a picture; applied by `adapt(quality)` of that part."""

    # Pixels of the canvas per pixel of the picture, along each side, in [0.25, 2]; ignored by rigs
    # that are exact.
    scale: float = 1.0
    # Samples per pixel of the canvas (MSAA); 0 none.
    samples: int = 0
    # True: the canvas holds light of any brightness; False: as integers, up to where it is shown as
    # white, which is cheaper without a GPU. Ignored with `bloom`, which needs what is brighter.
    floats: bool = True
    # True: smooth edges in the finished picture, by their contrast.
    smooth: bool = True
    # Factor on the pixels by which levels of detail are chosen: larger is finer.
    detail: float = 1.0
    # False: fishes of a few pixels are drawn as dots of ten triangles.
    fine_specks: bool = True
    # Share of corals and of clusters of seaweed that is drawn, in [0, 1].
    growth: float = 1.0
    # Specks of marine snow in the box about the eye.
    snow: int = 1400
    # Samples of each light shaft; 0 none.
    shafts: int = 8
    # True: fishes and the submarine darken the sand beneath.
    shadows: bool = True
    # Texels a side of the map of shadows of all that stands; 0: no such map.
    sun_map: int = 0
    # The same of the fishes, instead of soft spots on the sand; needs `sun_map`.
    fish_map: int = 0

    # True: light spreads around what is very bright, in pictures of one eye.
    bloom: bool = False

    # True: finished pictures have 16 bits, and not 8: for films with more than 256 levels.
    deep: bool = False

    # True: details that show at arm's length, such as polyps of corals and veins of leaves.
    close_up: bool = True

    @property
    def defines(self) -> tuple[str, ...]:
        """The defines of the program variants of a picture in daylight."""
        chosen = {
            "INTEGERS": self.integers,
            "CLOSE_UP": self.close_up,
            "SUN_MAP": self.sun_map,
            "FISH_MAP": self.sun_map and self.fish_map,
        }
        return tuple(define for define, wanted in chosen.items() if wanted)

    @property
    def integers(self) -> bool:
        """True if the canvas holds integers."""
        return not (self.floats or self.bloom)

    @property
    def canvas(self) -> tuple[float, int, bool, bool]:
        """All that the canvas and the finished pictures depend on."""
        return self.scale, self.samples, self.integers, self.deep

    @property
    def packing(self) -> PackOptions:
        """The options of `frame.packet.pack` for this quality."""
        return PackOptions(self.detail, self.growth, dots=not self.fine_specks)


PRESETS = {
    "low": Quality(
        floats=False,
        smooth=False,
        detail=0.7,
        fine_specks=False,
        growth=0.6,
        snow=700,
        shafts=6,
        close_up=False,
    ),
    "medium": Quality(sun_map=1024),
    "high": Quality(
        samples=4, detail=1.6, snow=2400, shafts=16, sun_map=2048, fish_map=1024, bloom=True
    ),
    # For GPUs with time to spare, and films.
    "ultra": Quality(
        samples=8, detail=2.6, snow=4000, shafts=32, sun_map=4096, fish_map=2048, bloom=True
    ),
}
CHOICES = (AUTO, *PRESETS)

# Qualities for `auto`, cheapest first: the lowest preset at growing scales, in steps too small
# to see, then the presets in full.
LADDER = (
    *(
        replace(PRESETS["low"], scale=round(SMALLEST_SCALE + k * SCALE_STEP, 2))
        for k in range(round((1.0 - SMALLEST_SCALE) / SCALE_STEP))
    ),
    *PRESETS.values(),
)


def check_choice(name: str) -> str:
    """Return the name of a preset, or "auto"; raise UserError for any other."""
    if name not in CHOICES:
        raise unknown("quality", name, list(CHOICES))
    return name


def name_of(quality: Quality) -> str:
    """The name of the preset, with the scale of the canvas if it is not 1."""
    full = replace(quality, scale=1.0)
    name = next((name for name, preset in PRESETS.items() if preset == full), "own")
    return name if quality.scale == 1.0 else f"{name} at {quality.scale:.0%}"


def on_software(renderer: str) -> bool:
    """True if the `GL_RENDERER` of a context is a software renderer."""
    return any(name in renderer.lower() for name in SOFTWARE)


def first_rung(renderer: str) -> int:
    """The index in LADDER at which `auto` begins: low without a GPU, high with one."""
    return LADDER.index(PRESETS["low" if on_software(renderer) else "high"])
