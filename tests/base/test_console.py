"""Messages are single lines."""

from subsea.base.progress import say


def test_a_line_break_in_a_name_does_not_break_the_line(capsys):
    say("filming to a\nb\udcff")
    assert capsys.readouterr().err == "subsea: filming to a?b\\udcff\n"
