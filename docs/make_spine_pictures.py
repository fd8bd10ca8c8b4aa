"""Make the pictures of docs/spine.md: `python docs/make_spine_pictures.py [FOLDER]`.

spine_swings.png: a beat of the ribbon eel's spine seen from above, for both swing functions and
for two rules of propagation (KS's movies B1 and B2).
"""

import sys
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from matplotlib.figure import Figure

from subsea.kinematics.spine import MIDDLES, UNITS, spines, swung
from subsea.species import load_species

SPECIES = "ribbon_eel"
MOMENTS = 9
COLOURS = ("#0b3c8c", "#d8a200")


def swings() -> Any:
    """The spine at moments of half a beat, and the directions of its units."""
    plan = load_species(SPECIES).spine
    assert plan
    picture = Figure(figsize=(11, 7))
    rows = picture.subplots(2, 3, width_ratios=(1, 1, 1.1))
    beat = np.linspace(0.0, 0.5, MOMENTS)
    straight = np.zeros((MOMENTS, UNITS))
    for row, propagation in zip(rows, ("tailward", "at once"), strict=True):
        for axis, function, colour in zip(row, ("sinusoidal", "linear"), COLOURS, strict=False):
            swing = msgspec.structs.replace(plan.swing, function=function, propagation=propagation)
            one = msgspec.structs.replace(plan, swing=swing)
            place = spines(one, beat, 1.0, straight, np.ones(UNITS)).place
            for k, shape in enumerate(place):
                axis.plot(-shape[:, 1], shape[:, 0], color=colour, alpha=0.25 + 0.75 * k / MOMENTS)
            axis.set(aspect="equal", xlim=(-0.2, 0.2), title=f"{function}, {propagation}")
            axis.tick_params(labelsize=7)
            if row is rows[0]:
                along, over = MIDDLES, np.zeros(1)
            else:
                along, over = np.full(1, plan.swing.inflections[1]), np.linspace(0.0, 2.0, 200)
            direction = np.degrees(swung(swing, along, over, 1.0))
            row[2].plot(along if len(over) == 1 else over, direction, color=colour, label=function)
        row[2].set_ylabel("direction of the units, degrees")
        row[2].legend(fontsize=8)
    for at in plan.swing.inflections:
        rows[0, 2].axvline(at, color="0.8", zorder=0)
    rows[0, 2].set(xlabel="behind the snout, L", title="along the spine, as a beat begins")
    rows[1, 2].set(xlabel="beats", title="at the central inflection point")
    rows[0, 0].set_ylabel("ahead of the centre, L")
    rows[1, 0].set_ylabel("ahead of the centre, L")
    picture.tight_layout()
    return picture


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures"
    folder.mkdir(exist_ok=True)
    swings().savefig(folder / "spine_swings.png", dpi=80, metadata={"Software": None})
