"""The notice in files is that of the licence, and names who made the fish."""

from pathlib import Path

from subsea.export.licence import HOLDER, SENTENCE, copyright_line

LICENSE = Path(__file__).parents[2] / "LICENSE"


def test_the_holder_is_that_of_the_licence() -> None:
    lines = LICENSE.read_text().splitlines()
    assert lines[0] == "MIT License" and HOLDER in lines
    assert SENTENCE.startswith("MIT licence")


def test_a_species_of_the_user_stays_his() -> None:
    ours = f"{HOLDER}. {SENTENCE}"
    assert copyright_line(["fusilier", "clownfish"]) == ours
    mixed = copyright_line(["my_guppy", "fusilier", "my_guppy"])
    assert mixed == f"{ours} Shapes and skins of my_guppy: their author."
