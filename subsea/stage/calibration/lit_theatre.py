"""The channels of a theatre that structured light can measure, and their surfaces."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from subsea.base.errors import UserError
from subsea.stage.calibration.surface import LitSurface, surface_of
from subsea.stage.theatre.channels import ProjectorChannel, usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.theatre_file import Theatre
from subsea.stage.theatre.theatre_rig import visible_channels


@dataclass(frozen=True)
class LitTheatre:
    """The channels of a theatre and the surfaces that they light, in real centimetres."""

    theatre: Theatre
    path: Path
    channels: Sequence[ProjectorChannel]

    @property
    def surfaces(self) -> list[LitSurface]:
        """The surface of each channel; a UserError for a screen whose shape is not known."""
        found = []
        for channel in self.channels:
            surface = surface_of(self.theatre, channel)
            if surface is None:
                kind = channel.shape.name.lower()
                raise UserError(
                    f"channel {channel.name!r}: a {kind} has no shape that a camera could measure; "
                    "expected plane, cylinder, angles or dome",
                    file=self.path,
                )
            found.append(surface)
        return found


def lit_theatre(name: str) -> LitTheatre:
    """Load a theatre whose channels all work; else a UserError."""
    theatre, path = load_theatre(name)
    if path.suffix != ".toml" or theatre.mpcdi:
        raise UserError(
            "expected a theatre file without [[mpcdi]]; write one with "
            f"`subsea theatre {path.name} --write OUT.toml`",
            file=path,
        )
    theatre = msgspec.structs.replace(theatre, scale=1.0)
    found, faults = usable_channels(theatre, path)
    found, unseen = visible_channels(theatre, found)
    for fault in (*faults, *unseen):
        raise fault
    return LitTheatre(theatre, path, found)
