"""A node of a dive without a window, in its own process; prints a line for each picture.

    python node_process.py master|NODE ADDRESS SCENARIO PICTURES NODES [KEYS]

A master waits until all NODES (a,b) are in step, makes PICTURES pictures (-1 for ever), and
reports. Every line of standard output is `TICK CHECKSUM`; messages of nodes go to standard error.
"""

import signal
import sys
import time
from pathlib import Path

from subsea.base.errors import UserError
from subsea.scenario.load import load_scenario
from subsea.stage.cluster.follower import Follower
from subsea.stage.cluster.keys import read_keys
from subsea.stage.cluster.master import Master
from subsea.submarine.vessel import NEUTRAL, Helm
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step

TIMEOUT_S = 1.0


def say(message):
    print(message, file=sys.stderr, flush=True)


def show(world):
    print(world.state.tick, snapshot.checksum(world), flush=True)


def helms(picture):
    """Zero to three ticks a picture, with varied steering."""
    return [Helm(surge=0.5, yaw=((7 * picture + k) % 11 - 5) / 5) for k in range(picture % 4)]


def lead(world, address, nodes, pictures, keys):
    node = Master(world, nodes, address, keys, TIMEOUT_S, say)
    node.resume()
    while len(node.in_step()) < len(nodes):
        node.picture([], 0.5)
        node.swap()
        time.sleep(0.01)
    picture = 0
    while pictures < 0 or picture < pictures:
        node.picture(helms(picture), (picture % 10) / 10)
        node.swap()
        show(world)
        picture += 1
    for line in node.report():
        say(line)
    node.close()


def follow(world, name, address, keys):
    node = Follower(world, name, "master", address, keys, TIMEOUT_S, say)
    while True:
        if node.picture(0.05) is not None:
            node.swap()
            show(world)


def main(role, address, scenario, pictures, nodes, keys=""):
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    names = nodes.split(",")
    others = names if role == "master" else ["master"]
    given = read_keys(Path(keys), role, others) if keys else None
    world = create_world(load_scenario(scenario)[0], fish=4)
    step(world, NEUTRAL)
    try:
        if role == "master":
            lead(world, address, names, int(pictures), given)
        else:
            follow(world, role, address, given)
    except UserError as fault:
        say(f"fault: {fault}")
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
