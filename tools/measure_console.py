"""Measure what the presenter's console costs a dive.

    python -m tools.measure_console [--rounds N] [--scenario NAME] [--size WxH]

Opens a dive on a virtual display and draws frames for a second each, in turn: without a console,
with one that nobody uses, with one page, and with 100 clients that ask as fast as they can, from a
process of their own. Prints the median of a frame by the clock and of the processor time of its
thread, the ratio to the frames without a console, and what hardly depends on other programs: the
processor time that the console takes of the frame's thread and in its own, as shares of a second.
"""

import argparse
import http.client
import json
import multiprocessing
import os
import socket
import threading
import time
from collections.abc import Callable
from contextlib import closing, suppress
from ipaddress import ip_address
from typing import Any

import numpy as np

from subsea.base.interrupts import deferred_interrupts
from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.stage.console.options import ConsoleOptions, ListenAddress
from subsea.stage.console.remote_control import RemoteControl, open_console
from subsea.ui.dive import Dive
from tools.monkey import virtual_display

SLICE_S, SETTLE_S = 1.0, 3.0  # of a case in each round, and before it
CLIENTS = {"no console": 0, "nobody": 0, "one page": 1, "100 clients": 100}


def main() -> None:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--scenario", default="peaceful")
    parser.add_argument("--size", default="640x360")
    options = parser.parse_args()
    width, height = map(int, options.size.split("x"))
    with virtual_display() as name:
        os.environ["DISPLAY"] = name
        display = DisplayOptions(size=(width, height), quality="low")
        chosen = DiveOptions(options.scenario, display=display, seed=1)
        with deferred_interrupts() as check, closing(Dive(chosen, check=check)) as dive:
            measure(dive, options.rounds)


def measure(dive: Dive, rounds: int) -> None:
    """Measure all cases in turn, and print them."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = int(free.getsockname()[1])
    open_console(dive, ConsoleOptions(ListenAddress(ip_address("127.0.0.1"), port)))
    remote = dive.remote
    assert remote is not None
    wanted, answered = multiprocessing.Value("i", 0), multiprocessing.Value("i", 0)
    crowd = multiprocessing.Process(target=visit, args=(port, wanted, answered), daemon=True)
    crowd.start()
    spent: dict[str, list[tuple[float, float]]] = {what: [] for what in CLIENTS}
    answers = dict.fromkeys(CLIENTS, 0)
    own: dict[str, list[float]] = {what: [0.0, 0.0] for what in CLIENTS}
    within = timed(remote)
    assert remote._server is not None and remote._server._thread.ident is not None
    clock = time.pthread_getcpuclockid(remote._server._thread.ident)
    frames(dive, 3.0)
    for _ in range(rounds):
        for what, clients in CLIENTS.items():
            dive.remote = None if what == "no console" else remote
            wanted.value = clients
            frames(dive, SETTLE_S)
            before, start = answered.value, (within[0], time.clock_gettime(clock))
            spent[what] += frames(dive, SLICE_S)
            answers[what] += answered.value - before
            own[what][0] += within[0] - start[0]
            own[what][1] += time.clock_gettime(clock) - start[1]
    wanted.value = -1
    crowd.join(10.0)
    dive.remote = remote
    report(spent, own, answers, rounds * SLICE_S)


def timed(remote: RemoteControl) -> list[float]:
    """Measure the calls of the remote control; returns where their processor time adds up, s."""
    total = [0.0]

    def wrapped(act: Callable[..., None]) -> Callable[..., None]:
        def measured(*given: float) -> None:
            start = time.thread_time()
            act(*given)
            total[0] += time.thread_time() - start

        return measured

    for name in ("update", "look"):
        setattr(remote, name, wrapped(getattr(remote, name)))
    return total


def frames(dive: Dive, seconds: float) -> list[tuple[float, float]]:
    """Durations of the frames that are drawn in that time: by the clock and of the thread, s."""
    spent: list[tuple[float, float]] = []
    begun = last = time.perf_counter()
    used = time.thread_time()
    while last - begun < seconds:
        dive.frame(spent[-1][0] if spent else 0.02)
        now, then = time.perf_counter(), time.thread_time()
        spent.append((now - last, then - used))
        last, used = now, then
    return spent


def visit(port: int, wanted: Any, answered: Any) -> None:
    """Ask for the state and pictures by as many clients as `wanted`; -1: end.

    One client pauses as the page does, more do not.
    """

    def ask(number: int) -> None:
        paths = ["/api/picture.jpg", "/api/state"]
        while wanted.value >= 0:
            with suppress(OSError, http.client.HTTPException):
                client = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
                with closing(client):
                    while number < wanted.value:
                        client.request("GET", paths[0])
                        client.getresponse().read()
                        paths.reverse()
                        with answered.get_lock():
                            answered.value += 1
                        time.sleep(0.2 if wanted.value == 1 else 0.0)
            time.sleep(0.05)

    threads = [threading.Thread(target=ask, args=(k,)) for k in range(100)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def report(
    spent: dict[str, list[tuple[float, float]]],
    own: dict[str, list[float]],
    answers: dict[str, int],
    seconds: float,
) -> None:
    """Print the frames of each case."""
    plain = np.median(spent["no console"], axis=0)
    for what, times in spent.items():
        median = np.median(times, axis=0)
        row = {
            "case": what,
            "frames": len(times),
            "ms": round(1e3 * float(median[0]), 2),
            "cpu_ms": round(1e3 * float(median[1]), 2),
            "ratio": round(float(median[0] / plain[0]), 3),
            "cpu_ratio": round(float(median[1] / plain[1]), 3),
            "of_frames_percent": round(100.0 * own[what][0] / seconds, 2),
            "server_percent": round(100.0 * own[what][1] / seconds, 2),
            "answers_a_s": round(answers[what] / seconds, 1),
        }
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
