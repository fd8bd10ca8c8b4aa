import pytest
from msgspec import structs

from capture.recording import fingerprint as module
from capture.recording.fingerprint import code_of, fingerprint
from subsea.fish.species import load_species


def test_it_depends_on_plans_and_code_and_not_on_names_and_colours(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    species = load_species("fusilier")
    body, skin = species.body, species.skin
    assert body is not None
    renamed = structs.replace(species, name="Redback fusilier", kind="pacifist")
    repainted = structs.replace(species, skin=structs.replace(skin, gloss=0.1))
    heavier = structs.replace(species, body=structs.replace(body, water_drag=1.01))
    alone = structs.replace(species, schooling=False)
    assert fingerprint(species) == fingerprint(renamed) == fingerprint(repainted)
    before = {fingerprint(one) for one in (species, heavier, alone)}
    assert len(before) == 3
    now = fingerprint(species)
    monkeypatch.setattr(module, "__version__", "another")  # the code is hashed instead
    assert fingerprint(species) == now
    monkeypatch.setattr(module, "_code_hash", lambda root: "another")
    assert fingerprint(species) not in before


def test_the_code_is_that_of_the_recorder_and_its_imports() -> None:
    """Every module that `record` imports, directly or not, but for files and species."""
    import grimp

    names = module.code_modules()
    graph = grimp.build_graph("subsea", "capture", cache_dir=None)
    upstream = graph.find_upstream_modules(module.ROOT) | {module.ROOT}
    read = {name for name in upstream if not name.startswith(module.SKIPPED)}
    assert set(names) <= read
    # Imports of only the reader of species are left out with it.
    assert {"subsea.biomechanics.solver", "subsea.geometry.rotation", module.ROOT} <= set(names)


CODE = '''"""Module."""

LIMIT = 3
"""Attribute."""


def double(x):
    """Docstring."""
    if x > LIMIT:
        x = 0
    return 2 * x  # comment
'''


def test_only_code_counts() -> None:
    for old, new, same in (
        ("Module", "The module", True),
        ('"""Attribute."""\n', "", True),
        ("# comment", "", True),
        ("2 * x", "2*x", True),
        ("2 * x", "3 * x", False),
        ("    return", "        return", False),
        ("LIMIT = 3", "LIMIT = 4", False),
    ):
        assert old in CODE
        assert (code_of(CODE.replace(old, new)) == code_of(CODE)) == same
