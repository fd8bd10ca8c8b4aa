"""`subsea fleet` on the command line: what it prints, and one line for each fault."""

import threading
import time

import pytest

from subsea import __version__
from subsea.cli.main import main
from subsea.stage.fleet import rollout
from subsea.stage.fleet.hand_over import is_wanted, wait_until_free
from tests.stage.fleet.conftest import NODES, version
from tests.stage.fleet.test_installing import make_wheel

WINDOW = '[[window]]\nname = "{0}"\nnode = "{0}"\nsize = [64, 48]\n'
CHANNEL = '[[channel]]\nname = "{0}"\nwindow = "{0}"\nangles = {{ left_deg = -9, right_deg = 9, '
CHANNEL += "down_deg = -9, up_deg = 9 }}\n"


def theatre(folder, cluster):
    path = folder / "hall.toml"
    shown = "".join((WINDOW + CHANNEL).format(name) for name in ("middle", *NODES))
    path.write_text(shown + cluster)
    return str(path)


CLUSTER = '[cluster]\nmaster = "middle"\naddress = "{address}"\n'


@pytest.mark.parametrize(
    ("words", "cluster", "said"),
    [
        (["status", "HALL"], "", "expected a table [cluster]"),
        (["status", "HALL"], CLUSTER.format(address="127.0.0.1:5560"), "[cluster] names no `keys`"),
        (["update", "HALL"], "", "fleet update: needs a WHEEL"),
        (["rollback", "HALL", "a.whl"], "", "fleet rollback: takes no WHEEL"),
        (["update", "HALL", "hall.whl"], "", "expected a wheel of subsea"),
    ],
)
def test_faults_are_one_line(tmp_path, capsys, words, cluster, said):
    path = theatre(tmp_path, cluster)
    assert main(["fleet", *(path if word == "HALL" else word for word in words)]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert line.startswith("subsea: ")
    assert said in line


def test_an_address_that_the_dive_of_the_master_has(hall, tmp_path, capsys):
    made, _, _ = hall
    text = CLUSTER.format(address=made._call.address) + 'keys = "keys"\n'
    assert main(["fleet", "status", theatre(tmp_path, text)]) == 2
    assert capsys.readouterr().err.strip().endswith("close the dive of the master first")


def test_an_update_waits_until_the_dive_of_the_master_has_ended(hall, tmp_path, capsys):
    made, _, own = hall
    address = made._call.address
    path = theatre(tmp_path, CLUSTER.format(address=address) + 'keys = "keys"\n')
    ended = []

    def dive():
        """Looks for the command, ends, and waits."""
        while not is_wanted(address):
            time.sleep(0.05)
        made._call.close()
        wait_until_free(address, ended.append)
        ended.append("free")

    thread = threading.Thread(target=dive)
    thread.start()
    assert main(["fleet", "rollback", path]) == 2  # this computer has no version before
    told = capsys.readouterr().err
    thread.join(30.0)
    assert "waits until the dive of the master ends with the item of its show" in told
    assert "waits for left, right" in told and "close the dive" not in told
    assert ended == ["waits for `subsea fleet`, then starts again", "free"]
    assert version(own) == "1.0"


def test_versions_are_listed_and_missing_nodes_stop_an_update(hall, tmp_path, capsys, monkeypatch):
    made, nodes, _ = hall
    address = made._call.address
    made._call.close()
    path = theatre(tmp_path, CLUSTER.format(address=address) + 'keys = "keys"\n')
    assert main(["fleet", "status", path]) == 1  # they have version 1.0
    out = capsys.readouterr().out.splitlines()
    assert out[0] == f"middle: subsea {__version__}, this computer"
    assert {line[:18] for line in out[1:]} == {"left: subsea 1.0, ", "right: subsea 1.0,"}
    nodes["right"].on_duty = False
    monkeypatch.setattr(rollout, "CALL_S", 1.0)
    assert main(["fleet", "update", path, str(make_wheel(tmp_path, "4.0"))]) == 2
    told = capsys.readouterr()
    assert "right: has not called" in told.out
    assert "right: has not called, so nothing was changed; start its dive" in told.err
