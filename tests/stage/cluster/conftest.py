"""Small equal worlds, free addresses, and nodes that run in threads."""

import threading
import time
from contextlib import ExitStack, closing

import pytest

from subsea.base.errors import UserError
from subsea.scenario.load import load_scenario
from subsea.stage.cluster.follower import Follower
from subsea.stage.cluster.master import Master
from subsea.submarine.vessel import NEUTRAL, Helm
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step
from tests.stage.console.conftest import free_port
from tests.support.scenes import BARE

TIMEOUT_S = 5.0  # a busy machine must not count as a late node


def small_sea(fish=4, seed=None):
    world = create_world(load_scenario(str(BARE))[0], seed=seed, fish=fish)
    step(world, NEUTRAL)
    return world


@pytest.fixture(scope="session")
def seas():
    """Three equal worlds, for a master and two nodes; tests share and advance them."""
    return [small_sea() for _ in range(3)]


@pytest.fixture
def address():
    return free_address()


def free_address():
    return f"127.0.0.1:{free_port()}"


class NodeThread(threading.Thread):
    """A running node: `seen` has tick and checksum after each of its pictures, by number."""

    def __init__(self, node):
        super().__init__(daemon=True)
        self.node, self.seen, self.fault = node, {}, None
        self.on_duty, self.asleep, self._resting = True, False, threading.Event()
        self.start()

    def run(self):
        try:
            while self.on_duty:
                if self.asleep:
                    self._resting.set()
                    time.sleep(0.01)
                elif self.node.picture(0.02) is not None:
                    world = self.node.world
                    self.seen[self.node._number] = world.state.tick, snapshot.checksum(world)
                    self.node.swap()
        except UserError as fault:
            self.fault = str(fault)
        finally:
            self.node.close()

    def rest(self):
        """Pause until `asleep` is reset."""
        self._resting.clear()
        self.asleep = True
        assert self._resting.wait(60.0)

    def close(self):
        self.on_duty = False
        self.join(60.0)
        assert not self.is_alive()


class MasterHarness:
    """A master that makes pictures on request, and its reports."""

    def __init__(self, world, address, nodes=("left", "right"), keys=None, timeout_s=TIMEOUT_S):
        self.told, self.seen, self._timeout_s = [], {}, timeout_s
        self.address, self._stack = address, ExitStack()
        self.master = Master(world, nodes, address, keys, timeout_s, self.told.append)
        self._stack.callback(self.master.close)

    def node(self, world, name, keys=None, told=None):
        """Start a new node."""
        tell = (lambda words: None) if told is None else told.append
        node = Follower(world, name, "master", self.address, keys, self._timeout_s, tell)
        return self._stack.enter_context(closing(NodeThread(node)))

    def show_pictures(self, pictures=1, ticks=1):
        for _ in range(pictures):
            self.master.picture([Helm(surge=0.5, yaw=0.3)] * ticks, 0.25)
            self.master.swap()
            world = self.master.world
            self.seen[self.master._number] = world.state.tick, snapshot.checksum(world)

    def show_until(self, true, seconds=60.0):
        end = time.monotonic() + seconds
        while not true() and time.monotonic() < end:
            self.show_pictures()
            time.sleep(0.002)
        assert true()

    def close(self):
        self._stack.close()


@pytest.fixture
def make_harness():
    """A function that makes master harnesses, which are closed at the end."""
    with ExitStack() as stack:
        yield lambda *given, **more: stack.enter_context(closing(MasterHarness(*given, **more)))


@pytest.fixture
def harness(make_harness, seas, address):
    return make_harness(seas[0], address)


@pytest.fixture(scope="session")
def make_sea():
    """A maker of small seas: `make_sea(fish=4, seed=None)`."""
    return small_sea
