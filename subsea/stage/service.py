"""Run a dive as a service: its systemd unit, and reports to its service manager by sd_notify(3)."""

import os
import socket
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from subsea.base.command_line import TRANSIENT
from subsea.base.errors import UserError, printable
from subsea.base.file_kinds import check_result, signed
from subsea.base.files import replacing
from subsea.base.interrupts import INTERRUPTED
from subsea.base.progress import print_line
from subsea.base.system import is_path
from subsea.dive.directed_camera import check_tour
from subsea.dive.options import DiveOptions
from subsea.scenario.load import load_scenario
from subsea.scenario.shoals import with_total

EVERY_S = 1.0  # between two reports of pictures
SOCKET = "NOTIFY_SOCKET"  # variable with the address; "@" begins an abstract one


def notify(**fields: object) -> None:
    """Send fields such as ``READY=1``; without a service manager do nothing.

    Never waits: a message that cannot be sent at once is dropped.
    """
    address = os.environ.get(SOCKET, "")
    if not address or not hasattr(socket, "AF_UNIX"):
        return
    text = "\n".join(f"{name}={printable(str(value))}" for name, value in fields.items())
    with suppress(OSError, ValueError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.setblocking(False)
        sender.sendto(text.encode(), f"\0{address[1:]}" if address.startswith("@") else address)


class PictureReports:
    """Reports of shown pictures: the first makes the service ready, each keeps its watchdog calm.

    A window that shows no pictures any more is silent, and the watchdog ends it.
    """

    def __init__(self) -> None:
        self._told = 0  # pictures in the last report
        self._last_s = 0.0

    def update(self, pictures: int, status: str, now_s: float | None = None) -> None:
        """Report the number of `pictures` shown so far, at most once a second."""
        now_s = time.monotonic() if now_s is None else now_s
        if pictures == self._told or (self._told and now_s - self._last_s < EVERY_S):
            return
        if self._told:
            rate = (pictures - self._told) / (now_s - self._last_s)
            notify(WATCHDOG=1, STATUS=f"{status}, {rate:.1f} pictures a second")
        else:
            notify(READY=1, WATCHDOG=1, STATUS=status)
        self._told, self._last_s = pictures, now_s


OPTION = "--write-unit"
MARK = f"# Written by `subsea dive {OPTION}`, which also replaces it.\n"
UNIT = signed("a unit of subsea", MARK.encode())
PATHS = {"--scenario": ".toml", "--theatre": ".toml", "--settings": "", "--playlist": ""}

TEXT = """[Unit]
Description={description}
PartOf=graphical-session.target
After=graphical-session.target
# Never give up: the display, the network or another computer may come at any time.
StartLimitIntervalSec=0

[Service]
# Ready when the first picture of the sea is shown; each later one keeps the watchdog calm.
Type=notify
ExecStart={command}
WatchdogSec=60
# The first start compiles.
TimeoutStartSec=15min
TimeoutStopSec=30
# 0: the operator's key. {stopped}: `systemctl stop`. 2: an error that starting again does not cure.
# {transient}: one that may pass, such as a display that is switched on later.
SuccessExitStatus={stopped}
Restart=on-failure
RestartPreventExitStatus=2
RestartSec=10
# The journal gets the stack of a dive that the watchdog ends.
Environment=PYTHONFAULTHANDLER=1
LimitCORE=0
SyslogIdentifier=subsea

[Install]
WantedBy=graphical-session.target
"""


def unit_path(node: str | None) -> Path:
    """The path of the unit of this user, for a node of a cluster or for one computer."""
    folder = os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config"
    name = "subsea.service" if node is None else f"subsea-{node}.service"
    return Path(folder) / "systemd" / "user" / name


def check_dive(options: DiveOptions) -> None:
    """Raise a UserError if a dive with these options would end at its start."""
    scenario = with_total(load_scenario(options.scenario, options.changes)[0], options.fish)
    check_tour(scenario, options.tour or options.settings.attract.tour)
    for part in options.parts:
        part.check(options)


def unit_text(words: Sequence[str], node: str | None = None) -> str:
    """Compose a unit for `subsea dive` with these options; their files get absolute paths."""
    python = str(Path(sys.executable).absolute())  # not what a link leads to
    program = [python, "-P", "-m", "subsea", "dive"]
    for word in words:
        name, equals, value = word.partition("=")
        if equals and name in PATHS:
            program.append(f"{name}={_path(name, value)}")
        else:
            program.append(_path(program[-1], word) if program[-1] in PATHS else word)
    return MARK + TEXT.format(
        description="subsea" if node is None else f"subsea, node {node}",
        command=" ".join(map(_quoted, program)),
        stopped=INTERRUPTED,
        transient=TRANSIENT,
    )


def write_unit(
    words: Sequence[str], options: DiveOptions, node: str | None = None, out: Path | None = None
) -> int:
    """Check a dive and write its unit to `out`, by default that of this user; exit code 0.

    `words` are the options of `subsea dive` as given, with the one that writes the unit. A unit
    that an operator wrote is not replaced.
    """
    check_dive(options)
    path = out or unit_path(node)
    kept = [word for word in words if not word.startswith(f"{OPTION}=")]
    if OPTION in kept:
        at = kept.index(OPTION)
        del kept[at : at + (1 if out is None else 2)]
    text = unit_text(kept, node)
    check_result(path, UNIT)
    with replacing(path) as part:
        part.write_text(text, encoding="utf-8")
    print_line(path)
    if out is None:
        print(f"`systemctl --user enable --now {path.stem}` starts it, now and at every login")
    return 0


def _path(option: str, text: str) -> str:
    """The absolute path of an option's file; names of shipped files stay."""
    suffix = PATHS[option]
    return str(Path(text).absolute()) if not suffix or is_path(text, suffix) else text


def _quoted(word: str) -> str:
    """A word of a unit's command line: systemd.syntax(7) and the escapes of systemd.service(5)."""
    if not word.isprintable():
        raise UserError(f"{word!r}: a unit holds only printable text")
    text = word.replace("\\", "\\\\").replace("%", "%%").replace("$", "$$")
    if word and not set(word) & set(" \t'\";\\"):
        return text
    return '"{}"'.format(text.replace('"', '\\"'))
