import importlib

from msgspec import structs

from capture.recording import fingerprint as module
from capture.recording.fingerprint import code_of, fingerprint
from subsea.fish.character import CharacterPlan
from subsea.fish.species import load_species


def test_it_depends_on_plans_and_code_and_not_on_names_and_colours(monkeypatch):
    species = load_species("fusilier")
    body, skin = species.body, species.skin
    assert body is not None
    renamed = structs.replace(species, name="Redback fusilier", kind="pacifist")
    repainted = structs.replace(species, skin=structs.replace(skin, gloss=0.1))
    shy = structs.replace(species, character=CharacterPlan(timidity=(2.0, 0.0)))
    heavier = structs.replace(species, body=structs.replace(body, water_drag=1.01))
    alone = structs.replace(species, schooling=False)
    lower = structs.replace(species, cruise_height=(0.5, 1.0))
    assert fingerprint(species) == fingerprint(renamed) == fingerprint(repainted)
    assert fingerprint(species) == fingerprint(lower) == fingerprint(shy)
    before = {fingerprint(one) for one in (species, heavier, alone)}
    assert len(before) == 3
    now = fingerprint(species)
    monkeypatch.setattr(module, "__version__", "another")  # the code is hashed instead
    assert fingerprint(species) == now
    monkeypatch.setattr(module, "_code_hash", lambda root: "another")
    assert fingerprint(species) not in before


def test_the_code_is_that_of_the_recorder_and_all_that_it_uses():
    """Functions of every module that `record` imports, but for files and species."""
    import grimp

    names = {name for name, _ in module.definitions()}
    graph = grimp.build_graph("subsea", "capture", cache_dir=None)
    upstream = graph.find_upstream_modules(module.ROOT) | {module.ROOT}
    assert names <= {name for name in upstream if not name.startswith(module.SKIPPED)}
    assert {"subsea.biomechanics.solver", "subsea.geometry.rotation", module.ROOT} <= names
    texts = "".join(module.definitions().values())
    for used, unused in (("advance", "fingerprint"), ("from_matrix", "slerp"), ("basis_at", "say")):
        assert f"def {used}(" in texts and f"def {unused}(" not in texts


FIRST = """
from capture.tried.other import LIMIT, doubled as twice
from capture.tried import other

@decorated
def tried(x):
    return twice(x) + other.called(x)
"""
OTHER = """
LIMIT = 3
STEPS = [1]
STEPS += [2]

def doubled(x):
    return below(x)

def below(x):
    return STEPS

def called(x):
    return 1

def unused(x):
    return LIMIT
"""


def test_code_is_found_by_what_uses_it_wherever_it_stands(tmp_path, monkeypatch):
    import capture

    (tmp_path / "tried").mkdir()
    monkeypatch.setattr(capture, "__path__", [*capture.__path__, str(tmp_path)])

    def found(**files):
        for name, text in files.items():
            (tmp_path / "tried" / f"{name}.py").write_text(text)
        for cached in (module._module, module._is_module):
            cached.cache_clear()
        importlib.invalidate_caches()
        return sorted(code_of(text) for text in module.definitions("capture.tried.first").values())

    code = found(__init__="", first=FIRST, other=OTHER)
    assert any(text.startswith("@decorated\ndeftried") for text in code)
    assert [text[:9] for text in code if text[:3] != "@de"] == [
        "STEPS+=[2", "STEPS=[1]", "defbelow(", "defcalled", "defdouble"
    ]  # fmt: skip
    assert found(other=OTHER.replace("return LIMIT", "return 0")) == code
    assert found(other=OTHER.replace("[2]", "[3]")) != code
    moved = OTHER.partition("def below")
    below = moved[1] + moved[2].partition("def called")[0]
    rest = OTHER.replace(below, "from capture.tried.third import below\n").replace(
        "STEPS += [2]", ""
    )
    rest = rest.replace("STEPS = [1]", "")
    assert found(other=rest, third=f"STEPS = [1]\nSTEPS += [2]\n\n{below}") == code


CODE = '''"""Module."""

LIMIT = 3
"""Attribute."""


def double(x):
    """Docstring."""
    if x > LIMIT:
        x = 0
    return 2 * x  # comment
'''


def test_only_code_counts():
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
