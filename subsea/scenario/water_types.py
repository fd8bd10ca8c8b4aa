"""Jerlov's optical water types: how fast daylight falls with depth, and what follows from it."""

from typing import Literal, NamedTuple

WaterType = Literal["I", "IB", "II", "III", "1C", "3C", "5C", "9C"]
Rgb = tuple[float, float, float]

# Share of 650 nm in the red channel of a camera; the rest is at 550 nm, where water absorbs little.
RED_SHARE = 0.5
# Backscatter of the water itself at 650, 550 and 450 nm (wavelength to the power -4.3), over that
# at 450 nm.
MOLECULES: Rgb = (0.206, 0.422, 1.0)
FAR_LUMINANCE, FAR_MOST = 0.072, 0.185  # of distant water, seen level: mean, and largest channel
LUMINANCE: Rgb = (0.2126, 0.7152, 0.0722)


class Jerlov(NamedTuple):
    """One type."""

    kd: Rgb  # diffuse attenuation, 1/m, at 650, 550 and 450 nm
    visibility_cm: float  # distance at which contrast falls to 2%, if a scenario does not say
    particles: float  # their backscatter over that of the water itself at 450 nm, in every colour


# Attenuation: I to 1C Austin and Petzold (1984), 3C to 9C Jerlov (1976).
JERLOV: dict[str, Jerlov] = {
    "I": Jerlov((0.356, 0.064, 0.018), 3200.0, 1.1),
    "IB": Jerlov((0.365, 0.072, 0.036), 2800.0, 0.9),
    "II": Jerlov((0.384, 0.086, 0.071), 2300.0, 0.6),
    "III": Jerlov((0.418, 0.114, 0.138), 1800.0, 0.7),
    "1C": Jerlov((0.453, 0.142, 0.205), 1400.0, 1.5),
    "3C": Jerlov((0.46, 0.19, 0.39), 1000.0, 3.0),
    "5C": Jerlov((0.54, 0.30, 0.56), 650.0, 5.0),
    "9C": Jerlov((0.76, 0.63, 1.6), 330.0, 8.0),
}


def attenuation(name: str) -> Rgb:
    """Diffuse attenuation of red, green and blue light in a type of water, 1/cm."""
    red, green, blue = JERLOV[name].kd
    return 0.01 * (RED_SHARE * red + (1.0 - RED_SHARE) * green), 0.01 * green, 0.01 * blue


def far_colour(name: str) -> Rgb:
    """Linear colour of distant water of a type, seen level: what it scatters over what it takes."""
    one = JERLOV[name]
    sent = [(pure + one.particles) / k for pure, k in zip(MOLECULES, one.kd, strict=True)]
    bright = sum(share * x for share, x in zip(LUMINANCE, sent, strict=True))
    scale = min(FAR_LUMINANCE / bright, FAR_MOST / max(sent))
    return scale * sent[0], scale * sent[1], scale * sent[2]
