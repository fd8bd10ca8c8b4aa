"""One dive in three processes: a node, then the master, is killed and restarted."""

import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.stage.cluster.conftest import free_address

NODE_PROCESS = Path(__file__).with_name("node_process.py")
TICKS, TICKS_AT_NIGHT = 200, 1000


class Process:
    """A node in its own process, and the lines that it has written."""

    def __init__(self, folder, call, *arguments):
        self._out, self._err = folder / f"{call}.out", folder / f"{call}.err"
        with self._out.open("w") as out, self._err.open("w") as err:
            self.process = subprocess.Popen(
                [sys.executable, str(NODE_PROCESS), *map(str, arguments)], stdout=out, stderr=err
            )

    @property
    def told(self):
        return self._err.read_text()

    @property
    def seen(self):
        """Ticks and checksums of its pictures, without a line cut off by a kill."""
        whole = self._out.read_text().rpartition("\n")[0].splitlines()
        return [(int(tick), checksum) for tick, checksum in map(str.split, whole)]

    def until(self, true, seconds=90.0):
        end = time.monotonic() + seconds
        while not true(self):
            assert time.monotonic() < end, self.told
            time.sleep(0.05)

    def kill(self):
        self.process.kill()
        self.process.wait()

    def end(self):
        self.process.terminate()
        return self.process.wait(60.0)


@pytest.fixture(scope="module")
def dive(tmp_path_factory, pytestconfig):
    ticks = TICKS_AT_NIGHT if pytestconfig.getoption("--nightly") else TICKS
    folder, address = tmp_path_factory.mktemp("dive"), free_address()
    crew = {}

    def start(call, role, pictures=0):
        crew[call] = Process(folder, call, role, address, "schooling", pictures, "left,right")
        return crew[call]

    try:
        start("left", "left")
        right, master = start("right", "right"), start("master", "master", -1)
        # Count ticks, not pictures: a waiting master repeats one tick.
        right.until(lambda node: len(dict(node.seen)) > 60)
        right.kill()
        there = len(dict(master.seen))
        master.until(lambda node: len(dict(node.seen)) > there + 60)
        again = start("right again", "right")
        again.until(lambda node: len(dict(node.seen)) > 60)
        master.until(lambda node: node.seen[-1][0] > ticks + 10)
        master.kill()
        for node in (crew["left"], again):
            node.until(lambda node: node.told.count("waiting for the master") == 2)
        second = start("second master", "master", 60)
        assert second.process.wait(90.0) == 0
        assert (crew["left"].end(), again.end()) == (130, 130)
        yield crew
    finally:
        for process in crew.values():
            process.kill()


def dives(process):
    """Its ticks and checksums, one mapping for each dive that it joined."""
    parts = [{}]
    before = 0
    for tick, checksum in process.seen:
        if tick < before:
            parts.append({})
        before = tick
        parts[-1][tick] = checksum
    return parts


def common(one, other):
    """Number of ticks that both have shown, with equal checksums."""
    both = sorted(one.keys() & other.keys())
    assert [one[tick] for tick in both] == [other[tick] for tick in both]
    return len(both)


@pytest.mark.nightly
def test_a_lasting_node_sees_the_same_ticks_as_the_master(dive):
    master, left = dives(dive["master"])[0], dives(dive["left"])[0]
    # Some pictures have no tick, some have three: ticks in between are never shown.
    assert max(master) - min(master) >= TICKS
    assert common(master, left) >= len(master) - 1
    assert len(set(master.values())) == len(master)


def test_a_restarted_node_sees_the_same_ticks(dive):
    master = dives(dive["master"])[0]
    before, after = dives(dive["right"])[0], dives(dive["right again"])[0]
    assert common(master, before) > 50
    assert common(master, after) > 50
    assert min(after) > max(before) + 50  # the others continued without it


def test_events_are_reported(dive):
    told = dive["master"].told
    assert "node right: is gone; going on without it" in told
    assert "node right: is in step again" in told
    assert "took the state of the dive at tick" in dive["right again"].told
    assert "differs" not in "".join(process.told for process in dive.values())


def test_a_restarted_master_resumes_the_dive(dive):
    [first], [second] = dives(dive["master"]), dives(dive["second master"])
    # A kill may cut off the last line of the master, and a picture that only nodes have made.
    assert 0 <= min(second) - max(first) <= 6
    for name in ("left", "right again"):
        [shown] = dives(dive[name])
        assert common(second, shown) >= len(second) - 1
    assert re.search(r"resumed the dive of node \w+ at tick", dive["second master"].told)
    told = dive["second master"].told
    for name in ("left", "right"):
        assert f"node {name}: " in told
    assert "ms on average, p95" in told
