"""The copyright line and the licence sentence that each exported file carries."""

from collections.abc import Iterable

from subsea.fish.species import is_shipped

HOLDER = "Copyright (c) 2026 The subsea authors"  # as in LICENSE
SENTENCE = "MIT licence: use, change and sell it, and keep this notice."


def copyright_line(species: Iterable[str] = ()) -> str:
    """The holder of the rights in a file with these species, and the licence.

    Species that the user made are his own, with their skins; the motion and the sea are ours.
    """
    own = sorted({name for name in species if not is_shipped(name)})
    rest = f" Shapes and skins of {', '.join(own)}: their author." if own else ""
    return f"{HOLDER}. {SENTENCE}{rest}"
