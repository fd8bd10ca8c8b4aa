"""Ticks that all computers of a cluster make together: those of its master, and of its nodes."""

import time
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from subsea.base.errors import UserError, unknown
from subsea.base.progress import say
from subsea.dive.idle_timer import TickClock
from subsea.dive.pilot import Pilot
from subsea.dive.presented import BLANK_S
from subsea.dive.tick_source import LocalTicks, SteeringSource, TickSource, TickSourceMaker
from subsea.dive.tour import Steer
from subsea.scenario.load import load_scenario, scenario_file, scenario_names
from subsea.stage.theatre.line_up import NOTHING_CHANGED, LineUpState
from subsea.stage.theatre.theatre_file import Theatre
from subsea.view.display_rigs import cockpit
from subsea.view.rig import CameraPose
from subsea.world.world import TICK_S, World

if TYPE_CHECKING:
    from subsea.stage.cluster.follower import Follower
    from subsea.stage.cluster.master import Master
    from subsea.ui.dive import Dive

FOLLOW_S = 30.0  # longest time for which a change of scenario waits for the nodes
LONGEST_S = 0.25  # longest step of that wait: a sea was loaded since the last picture
PATIENCE_S = 0.02  # a follower waits for the next picture before it handles window events
HOLD_S = 0.25  # longest wait of a follower while the master is silent


class LeaderTicks(TickSource):
    """Ticks as `LocalTicks`, made by all computers of a cluster together."""

    shared = True
    steering: SteeringSource

    def __init__(
        self, master: "Master", pilot: Pilot, tour: Steer | None = None, resumes: bool = True,
        leads: bool = False, awaited: Collection[str] = (),
    ) -> None:  # fmt: skip
        """`leads`: nodes open the scenario that this computer shows.

        The screens are black until the `awaited` nodes follow.
        """
        self._master, self._clock, self._resumes = master, TickClock(TICK_S), resumes
        self._leads = leads
        self._awaited, self._left_s = {*awaited}, FOLLOW_S
        self.gathering, self._shade = leads and bool(awaited), 0.0
        self.followers: list[str] = []  # of the scenario that was closed
        self.steering = SteeringSource(master.world, pilot, tour)

    def offer(self, scenario: Path) -> None:
        """Let nodes open this scenario, if they can by its name."""
        named = scenario.stem in scenario_names() and scenario_file(scenario.stem) == scenario
        self._master.offers = scenario.stem if self._leads and named else ""

    def resume(self, check: Callable[[], object]) -> None:
        """Go on from the state of the nodes, unless the dive is to start from its beginning."""
        if self._resumes:
            self._master.resume(check)

    def change(self) -> None:
        """Show a black picture everywhere, if the nodes are to open the next scenario."""
        if self._leads:
            self.presented = self._master.presented = replace(self.presented, blank=1.0)
            self._master.picture([], self._clock.alpha)
            self._master.swap()

    def advance(self, elapsed_s: float) -> float:
        """Make the ticks that are due, here and on all nodes."""
        self._gather(min(elapsed_s, LONGEST_S))
        ticks = self.steering.ticks(self._clock.advance(elapsed_s))
        self._master.presented = self.presented
        # The pilot's commands do not depend on the world: they can be sent ahead of the ticks.
        self._master.picture(ticks if self.steering.tour else list(ticks), self._clock.alpha)
        return self._clock.alpha

    def _gather(self, elapsed_s: float) -> None:
        """Keep the screens black until the nodes follow or time is over; then fade the sea in."""
        if self.gathering:
            self._left_s -= elapsed_s
            missing = sorted(self._awaited - {*self._master.in_step()})
            self.gathering = bool(missing and self._left_s > 0.0 and self._master.offers)
            if missing and self._left_s <= 0.0:
                say(f"{', '.join(missing)}: not followed in {FOLLOW_S:g} s; going on without")
            self._shade = 1.0
        else:
            self._shade = max(self._shade - elapsed_s / BLANK_S, 0.0)
        if self._shade > self.presented.blank:
            self.presented = replace(self.presented, blank=self._shade)

    def eye(self) -> CameraPose:
        """Interpolate as on all nodes, a tick late."""
        return cockpit(self._master.world.state.submarine, self._clock.alpha)

    def line_up(self, state: LineUpState) -> None:
        """Let all nodes show this line-up."""
        self._master.line_up = None if state is NOTHING_CHANGED else state

    def reports(self) -> list[str]:
        """Take the lines of nodes for the presenter."""
        lines = list(self._master.reports)
        self._master.reports.clear()
        return lines

    def fleet_heard(self) -> list[tuple[str, bytes]]:
        """Take the messages of the fleet, each with its node."""
        heard = list(self._master.fleet_heard)
        self._master.fleet_heard.clear()
        return heard

    def send_fleet(self, name: str, data: bytes) -> None:
        """Send a message of the fleet to a node, if it is connected."""
        self._master.send_fleet(name, data)

    def asked(self) -> list[bytes]:
        """Take the commands of the nodes' keyboards."""
        commands = list(self._master.asked)
        self._master.asked.clear()
        return commands

    def renew_view(self, view: Mapping[str, str]) -> None:
        """Take other parts of the view that nodes must have, after a file was saved."""
        self._master.renew_view(view)

    def swap(self, drawn: Callable[[], None]) -> None:
        """Wait until all nodes have drawn."""
        drawn()
        self._master.swap()

    def nodes(self) -> list[dict[str, Any]]:
        """Describe all nodes but the master's own: docs/reference/console-interface.md."""
        return [
            {
                "name": node.name,
                "connected": node.route is not None,
                "in_step": node.in_step,
                "last_ms": 1e3 * node.waits.recent_s[-1] if node.waits.frames else 0.0,
                "mean_ms": 1e3 * node.waits.mean_s,
                "longest_ms": 1e3 * node.waits.longest_s,
                "late": node.waits.late,
                "dropped": node.waits.dropped,
                "diverged": node.waits.diverged,
                "refusal": node.refusal,
            }
            for node in self._master.nodes.values()
        ]

    def close(self) -> list[str]:
        """Report the wait times for each node."""
        report, self.followers = self._master.report(), self._master.in_step()
        self._master.close()
        return report


class FollowerTicks(TickSource):
    """The ticks of the master; while it is lost the world drifts on."""

    has_pilot, shared = False, True
    wanted: tuple[str, int] | None = None  # name and seed of the master's scenario

    def __init__(self, node: "Follower") -> None:
        self._node, self._alpha, self.waiting = node, 1.0, node.waiting
        self._clock = TickClock(TICK_S)  # while the master is lost

    def advance(self, elapsed_s: float) -> float | None:
        """Make the master's next ticks, independent of `elapsed_s` unless it is lost."""
        start = time.perf_counter()
        alpha = self._node.picture(HOLD_S if self.waiting and not self._node.lost else PATIENCE_S)
        self.waiting = self._node.waiting
        if alpha is None and self._node.lost:
            self._node.drift(self._clock.advance(elapsed_s))
            alpha = self._clock.alpha
        self.idle_s = time.perf_counter() - start
        self._alpha = self._alpha if alpha is None else alpha
        self.wanted = self._node.wanted
        if self._node.waiting == "":
            self.presented = self._node.presented
        return alpha

    @property
    def lined_up(self) -> LineUpState | None:
        """The line-up that the master has sent; None: none yet."""
        return self._node.line_up

    def ask(self, command: bytes) -> None:
        """Ask the master to apply a command of this node's keyboard."""
        self._node.ask(command)

    def fleet_heard(self) -> list[bytes]:
        """Take the messages of the fleet."""
        heard = list(self._node.fleet_heard)
        self._node.fleet_heard.clear()
        return heard

    def send_fleet(self, data: bytes) -> bool:
        """Send a message of the fleet to the master; False if there is no connection."""
        return self._node.send_fleet(data)

    def report(self, words: str) -> None:
        """Tell the presenter at the master a line."""
        self._node.report(words)

    def renew_view(self, view: Mapping[str, str]) -> None:
        """Take other parts of the view that must equal the master's, after a file was saved."""
        self._node.renew_view(view)

    def eye(self) -> CameraPose:
        """The pose of the master's eye."""
        return cockpit(self._node.world.state.submarine, self._alpha)

    def swap(self, drawn: Callable[[], None]) -> None:
        """Wait until the master and all other nodes have drawn."""
        drawn()
        if not self._node.lost:
            self._node.swap()

    def close(self) -> list[str]:
        """Report nothing: the master does."""
        self._node.close()
        return []


def tick_source_maker(
    theatre: Theatre, path: Path, node: str | None, view: Mapping[str, str], resumes: bool = True,
    leads: bool = False,
) -> TickSourceMaker:  # fmt: skip
    """The maker of the tick source on the computer `node` of a theatre with the file `path`.

    None: this computer shows all windows. `view` names parts of theatre and display that are equal
    on all computers. A master that `resumes` goes on with the dive of its nodes; one that `leads`
    has nodes open its scenarios. A UserError if keys are missing, before the world is loaded.
    """
    cluster = theatre.cluster
    if node is None or cluster is None:
        return LocalTicks
    from subsea.stage.cluster.follower import Follower
    from subsea.stage.cluster.link import credentials
    from subsea.stage.cluster.master import Master

    keys = credentials(cluster, theatre.nodes, node, path)
    address, timeout_s, master = cluster.address, cluster.timeout_s, cluster.master
    others = [name for name in theatre.nodes if name != node]
    last: list[LeaderTicks] = []  # of the sea before

    def made(world: World, pilot: Pilot) -> TickSource:
        if node == master:
            led = Master(world, others, address, keys, timeout_s, say, view)
            awaited = last[0].followers if last else ()
            # Only the first sea goes on with that of the nodes.
            last[:] = [LeaderTicks(led, pilot, None, resumes and not last, leads, awaited)]
            return last[0]
        return FollowerTicks(Follower(world, node, master, address, keys, timeout_s, say, view))

    return made


class MasterScenario:
    """Opens the scenario that the master of a node waits with."""

    def __init__(self) -> None:
        self._tried: tuple[str, int] | None = None
        self._told = False  # that it did not help

    def follow(self, dive: "Dive") -> None:
        """Open it once; a fault is one line, and the sea of before goes on."""
        ticks = dive.tick_source
        if not isinstance(ticks, FollowerTicks):
            return
        wanted, ticks.wanted = ticks.wanted, None
        if wanted is None or (wanted == self._tried and self._told):
            return
        name, seed = wanted
        try:
            if wanted == self._tried:
                raise UserError("its file, or those that it names, differ from the master's")
            if name not in (known := scenario_names()):  # not a path
                raise unknown("scenario", name, known)
            self._tried, self._told = wanted, False
            scenario, source, _ = load_scenario(name)
        except UserError as fault:
            self._tried, self._told = wanted, True
            dive.note(f"the master opens {name!r}: {fault}; this node waits for the next one")
            return
        before = dive.tick_source.presented
        dive.open_world(scenario, source, seed)
        dive.tick_source.presented = before  # until the master's first picture
