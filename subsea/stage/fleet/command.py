"""`subsea fleet`: versions of all computers of a theatre, updates, and the way back."""

import errno
import time
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from subsea.base.command_line import add_command
from subsea.base.errors import UserError
from subsea.base.progress import print_line, say

if TYPE_CHECKING:
    from subsea.stage.cluster.keys import Keys
    from subsea.stage.cluster.roll_call import RollCall

GROUP = "scenarios and theatres"  # in the help
LOOK_S = 0.2  # between two tries to listen


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "fleet",
        "update all computers of a theatre",
        "Run it on the master's computer: docs/how-to/fleet.md. `update` installs a wheel on all\n"
        "computers, `rollback` returns to the version before. A dive of the master ends with the\n"
        "item of its show, and starts again afterwards. `status` shows the versions, while that\n"
        "dive is closed and the nodes wait for it.",
        [
            "subsea fleet status hall.toml",
            "subsea fleet update hall.toml subsea-2.0-py3-none-any.whl",
            "subsea fleet rollback hall.toml",
        ],
    )
    parser.add_argument("what", choices=("status", "update", "rollback"), help="what to do")
    parser.add_argument("theatre", metavar="NAME|FILE", help="the theatre file, with [cluster]")
    parser.add_argument("wheel", metavar="WHEEL", nargs="?", type=Path, help="for update")
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Carry it out; 1 if a computer has not called, or has another version than this one."""
    if (options.wheel is not None) != (options.what == "update"):
        needs = "needs a WHEEL" if options.what == "update" else "takes no WHEEL"
        raise UserError(f"fleet {options.what}: {needs}")
    from contextlib import ExitStack, closing

    from subsea import __version__
    from subsea.stage.cluster.link import credentials
    from subsea.stage.fleet.hand_over import address_wanted
    from subsea.stage.fleet.rollout import Rollout
    from subsea.stage.fleet.updates import Updates
    from subsea.stage.fleet.wheel import read_wheel
    from subsea.stage.theatre.load import load_theatre

    wheel = None if options.wheel is None else read_wheel(options.wheel)
    theatre, path = load_theatre(options.theatre)
    cluster = theatre.cluster
    if cluster is None:
        raise UserError("has no [cluster], so one computer shows it", file=path)
    keys = credentials(cluster, theatre.nodes, cluster.master, path)
    if keys is None:
        raise UserError(
            "[cluster] names no `keys`: `subsea keys DIR NAME...` makes them", file=path
        )
    others = [name for name in theatre.nodes if name != cluster.master]
    with ExitStack() as held:
        if options.what != "status":
            held.enter_context(address_wanted(cluster.address))
        roll_call = held.enter_context(
            closing(_listening(cluster.address, keys, options.what != "status"))
        )
        own = held.enter_context(closing(Updates()))
        rollout = Rollout(roll_call, others, own, say)
        say(f"waits for {', '.join(others)}")
        missing = rollout.gather()
        print_line(f"{cluster.master}: subsea {__version__}, this computer")
        for name, facts in rollout.facts.items():
            print_line(f"{name}: subsea {facts.version}, {facts.system}")
        for name in missing:
            print_line(f"{name}: has not called")
        if options.what == "status":
            same = {facts.version for facts in rollout.facts.values()} <= {__version__}
            return 0 if same and not missing else 1
        if missing:
            names = ", ".join(missing)
            raise UserError(f"{names}: has not called, so nothing was changed; start its dive")
        if wheel is not None:
            rollout.update(wheel)
        else:
            rollout.roll_back()
    return 0


def _listening(address: str, keys: "Keys", waits: bool) -> "RollCall":
    """Listen at the address of the master, if `waits` once its dive has come to an end."""
    from subsea.stage.cluster.roll_call import RollCall

    told = False
    while True:
        try:
            return RollCall(address, keys)
        except UserError as fault:
            in_use = getattr(fault.__cause__, "errno", None) == errno.EADDRINUSE
            if not waits or not in_use:
                raise UserError(f"{fault}: close the dive of the master first") from fault
        if not told:
            say(
                "waits until the dive of the master ends with the item of its show; one of another "
                "user or an older version must be closed by hand"
            )
            told = True
        time.sleep(LOOK_S)
