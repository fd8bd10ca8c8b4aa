"""The last fault, and how long ago it was."""

from subsea.dive.captions import FaultLog


def test_the_last_fault_is_remembered(capsys):
    now = [5.0]
    faults = FaultLog(lambda: now[0])
    assert faults.state is None
    faults.add("one")
    now[0] = 8.0
    faults.say("two\nlines")
    now[0] = 9.5
    assert faults.state.text == "two?lines" and faults.state.ago_s == 1.5
    assert capsys.readouterr().err == "subsea: two?lines\n"
