"""The part of a dive that lets a technician see and control the computers of a theatre."""

import time
from argparse import Namespace
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any

from subsea.base.errors import TransientError, UserError
from subsea.base.progress import say
from subsea.dive.part import DivePart

if TYPE_CHECKING:
    from subsea.dive.options import DiveOptions
    from subsea.stage.fleet.desk import FleetDesk
    from subsea.stage.fleet.messages import NodeFacts
    from subsea.stage.fleet.station import FleetStation
    from subsea.stage.small_picture import SmallPicture
    from subsea.stage.theatre.theatre_file import Theatre
    from subsea.ui.dive import Dive

REPORT_S = 2.0  # between two reports of a node
LOOK_S = 1.0  # between two looks for a command that wants the address of the master
PICTURE_WIDTH = 320  # pixels


class FleetPart(DivePart):
    """Reports this computer to the master; on the master, keeps the technician's desk."""

    desk: "FleetDesk | None" = None  # on the master, or where one computer shows the theatre
    station: "FleetStation | None" = None  # on a node

    def __init__(self, theatre: str, node: str | None = None) -> None:
        """`theatre` is its name or file; without a `node` this computer shows all windows."""
        self._name, self._node = theatre, node
        self._passwords: list[str] = []  # of the projectors
        self._watch: Any = None
        self._small: SmallPicture | None = None
        self._reported_s = self._begun_s = 0.0
        self._address = ""  # of a master with keys
        self._looked_s = 0.0  # for a command that wants it
        self._wanted = False

    @classmethod
    def made(cls, options: Namespace, dive: "DiveOptions") -> "FleetPart | None":
        """Make the part for `--theatre`."""
        return None if options.theatre is None else cls(options.theatre, options.node)

    def check(self, options: "DiveOptions") -> None:
        """Raise a UserError for a faulty file of a projector's password."""
        from subsea.stage.fleet.projectors import read_passwords
        from subsea.stage.theatre.load import load_theatre

        theatre, path = load_theatre(self._name)
        if self._leads(theatre):
            self._passwords = read_passwords(theatre.projector, path)

    def plan(self, options: "DiveOptions") -> "DiveOptions":
        """Read the passwords of the projectors; a TransientError during an update."""
        from subsea.stage.fleet.hand_over import is_wanted
        from subsea.stage.theatre.load import load_theatre

        self.check(options)
        cluster = load_theatre(self._name)[0].cluster
        if cluster is not None and cluster.keys is not None and self._node == cluster.master:
            self._address = cluster.address
            if is_wanted(cluster.address):
                raise TransientError(
                    "`subsea fleet` works at the address of this master; start the dive after it"
                )
        return options

    def _leads(self, theatre: "Theatre") -> bool:
        cluster = theatre.cluster
        return self._node is None or cluster is None or self._node == cluster.master

    def begin(self, dive: "Dive") -> None:
        """Begin to report, and on the master to ask the projectors."""
        from subsea.base.system import own_path
        from subsea.stage.fleet.computer import ComputerWatch, system_name
        from subsea.stage.fleet.desk import FleetDesk
        from subsea.stage.fleet.projectors import Projectors
        from subsea.stage.fleet.station import FleetStation, FrameTimes
        from subsea.stage.fleet.updates import Updates
        from subsea.stage.theatre.load import load_theatre

        theatre, _ = load_theatre(self._name)
        self._frames, self._begun_s = FrameTimes(), time.monotonic()
        self._system = system_name()
        self._renderer = str(dive.window_set.context.info["GL_RENDERER"])[:200]
        self._watch = ComputerWatch(own_path("."))
        if self._leads(theatre):
            own = self._node or (theatre.cluster.master if theatre.cluster else theatre.nodes[0])
            names = (own,) if self._node is None else theatre.nodes
            projectors = Projectors(theatre.projector, self._passwords)
            self.desk = FleetDesk(names, own, theatre.node, projectors)
        else:
            keyed = theatre.cluster is not None and theatre.cluster.keys is not None
            self.station = FleetStation(Updates() if keyed else None)

    def before(self, dive: "Dive", elapsed_s: float) -> bool:
        """Exchange messages, and restart if that is asked for."""
        if self._watch is None:
            return False
        self._frames.add(elapsed_s)
        if self.desk is not None:
            self._lead(dive, self.desk)
        elif self.station is not None:
            self._follow(dive, self.station)
        return False

    def _lead(self, dive: "Dive", desk: "FleetDesk") -> None:
        """Hear the nodes, and send them the technician's orders."""
        from subsea.stage.cluster.ticks import LeaderTicks

        ticks = dive.tick_source
        if isinstance(ticks, LeaderTicks):
            for name, data in ticks.fleet_heard():
                with suppress(UserError):  # of another version, or damaged
                    desk.hear(name, data)
            desk.update(ticks.nodes())
            for name, data in desk.take_orders():
                ticks.send_fleet(name, data)
        else:
            desk.update(())
            desk.take_orders()
        if (facts := self._due_facts(dive)) is not None:
            desk.note_facts(desk.own, facts)
        for line in desk.projectors.check():
            dive.faults.say(line)  # not over the picture
        if (desk.restarts or self._hands_over(dive)) and not dive.restarts:
            dive.restart()

    def _hands_over(self, dive: "Dive") -> bool:
        """True if `subsea fleet` wants the address of this master, and the item of a show is over.

        The restart then waits until the command is done.
        """
        if not self._address:
            return False
        from subsea.base.restarts import wait_first
        from subsea.stage.fleet.hand_over import is_wanted, wait_until_free

        if (now := time.monotonic()) - self._looked_s >= LOOK_S:
            wanted, self._looked_s = is_wanted(self._address), now
            if wanted and not self._wanted:
                say("`subsea fleet` asks for the computers: the dive ends with this item")
            self._wanted = wanted
        if not self._wanted or dive.restarts or not all(part.may_end() for part in dive.parts):
            return False
        wait_first(partial(wait_until_free, self._address, say))
        return True

    def _follow(self, dive: "Dive", station: "FleetStation") -> None:
        """Report to the master, and follow its orders."""
        from subsea.stage.cluster.ticks import FollowerTicks
        from subsea.stage.fleet.messages import encode

        ticks = dive.tick_source
        if not isinstance(ticks, FollowerTicks):
            return
        for data in ticks.fleet_heard():
            with suppress(UserError):
                station.hear(data)
        if (facts := self._due_facts(dive)) is not None:
            ticks.send_fleet(encode(facts))
        for message in (*station.take_parts(), *station.take_answers()):
            ticks.send_fleet(message)
        if station.restarts and not dive.restarts:
            dive.restart()

    def _due_facts(self, dive: "Dive") -> "NodeFacts | None":
        """The state of this computer, if the last report is old enough."""
        now = time.monotonic()
        if now - self._reported_s < REPORT_S:
            return None
        from subsea import __version__
        from subsea.stage.cluster.messages import PROTOCOL
        from subsea.stage.fleet.messages import NodeFacts

        self._reported_s = now
        mean_ms, longest_ms = self._frames.take()
        fault = dive.faults.state
        return NodeFacts(
            __version__,
            PROTOCOL,
            self._system,
            self._renderer,
            self._watch.temperature_c,
            self._watch.free_disk_gb,
            mean_ms,
            longest_ms,
            now - self._begun_s,
            fault.text[:200] if fault else "",
            fault.ago_s if fault else 0.0,
        )

    def after(self, dive: "Dive") -> None:
        """Take a small picture on a node, if the technician wants one."""
        if self.station is None:
            return
        if self._small is None:
            from subsea.stage.small_picture import SmallPicture

            self._small = SmallPicture(dive.window_set.context, PICTURE_WIDTH)
        if (picture := self._small.read()) is not None:
            self.station.show(picture)
        elif self.station.picture_wanted:
            self._small.copy(dive.window_set.front.size)

    def close(self) -> None:
        """End the threads, and release the small picture."""
        for one in (self._watch, self.desk, self.station):
            if one is not None:
                one.close()
        self._watch, self.desk, self.station = None, None, None
        if self._small is not None:
            self._small.release()
            self._small = None


def fleet_of(parts: Any) -> FleetPart | None:
    """The fleet among the parts of a dive; None: it is not in a theatre."""
    return next((part for part in parts if isinstance(part, FleetPart)), None)
