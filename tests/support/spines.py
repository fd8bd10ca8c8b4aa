"""Species with a spine."""

from msgspec.structs import replace

from subsea.fish.species import Species, load_species


def by_rules(name: str) -> Species:
    """The shipped species ``name``, whose spine follows the rules of its swing without muscles."""
    species = load_species(name)
    assert species.spine
    wings = species.spine.wings and replace(species.spine.wings, muscles=None)
    return replace(species, spine=replace(species.spine, muscles=None, wings=wings))
