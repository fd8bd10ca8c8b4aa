"""The parts that exhibitions add to a dive: theatre, show, console, kiosk, headset, service.

Nothing here loads what a dive without the part does not need.
"""

import os
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

from subsea.base.command_line import number_reader
from subsea.base.errors import UserError
from subsea.base.progress import say
from subsea.dive import arguments as shared
from subsea.dive.part import GOES_ON, DivePart

if TYPE_CHECKING:
    from subsea.dive.options import DiveOptions
    from subsea.dive.presented import Presented
    from subsea.dive.tick_source import TickSourceMaker
    from subsea.stage.console.options import ConsoleOptions
    from subsea.stage.console.remote_control import RemoteControl
    from subsea.stage.line_up import TheatreLineUp
    from subsea.stage.overlays import MasterOverlay
    from subsea.stage.show_player import ShowScreens
    from subsea.stage.structured_light import StructuredLight
    from subsea.ui.dive import Dive
    from subsea.ui.monitors import Installation


LOOK_S = 15.0  # between attempts to find the lost headset of a kiosk
POINTER_S = 3.0  # until a resting pointer of a kiosk is hidden
AGAIN_S = 1.0  # between attempts to take the keyboard back


class TheatrePart(DivePart):
    """Shows the dive in a theatre, on this computer or with others."""

    waits = True

    def __init__(
        self, name: str, shrink: int = 1, node: str | None = None, resumes: bool = True,
        light: float | None = None,
    ) -> None:  # fmt: skip
        """`shrink` divides the pixels; without a `node` this computer shows all windows.

        A master that `resumes` goes on with the dive of its nodes when it is restarted. With
        `light` the dive shows structured light, each picture for that time, s; 0: until a key.
        """
        self.name, self.shrink, self.node, self.resumes = name, shrink, node, resumes
        self._light_s = light
        self._light: StructuredLight | None = None
        self._installation: tuple[Installation, TickSourceMaker] | None = None
        self.line_up: TheatreLineUp | None = None  # None: not planned yet
        self._overlay: MasterOverlay | None = None  # of a node

    @staticmethod
    def add_options(parser: ArgumentParser) -> None:
        """Add the options of a theatre of several computers."""
        group = parser.add_argument_group("in a theatre of several computers")
        group.add_argument(
            "--node",
            metavar="NAME",
            help="this computer's node of the theatre: docs/how-to/cluster.md",
        )
        group.add_argument(
            "--no-resume",
            action="store_true",
            help="on the master: start the dive from its beginning, even if nodes are in one",
        )
        parser.add_argument(
            "--structured-light",
            type=number_reader(float, 0.2, 600.0),
            nargs="?",
            const=0.0,
            metavar="SECONDS",
            help="in a theatre: show its projectors' structured light for a camera, so long each "
            "(default: until the key for the next cue): docs/how-to/calibrate.md",
        )

    @classmethod
    def made(cls, options: Namespace, dive: "DiveOptions") -> "TheatrePart | None":
        """Make the part for `--theatre`."""
        from subsea.view.display_rigs import HEADSET

        if options.theatre is not None and options.display == HEADSET:
            raise UserError(f"--theatre has windows of its own: expected no --display {HEADSET}")
        if options.theatre is None and options.shrink != 1:
            raise UserError("--shrink needs --theatre; give a smaller --size instead")
        if options.theatre is None and options.node is not None:
            raise UserError("--node needs --theatre too")
        if options.no_resume and options.node is None:
            raise UserError("--no-resume needs --theatre and --node too")
        if options.structured_light is not None and options.theatre is None:
            raise UserError("--structured-light needs --theatre too")
        if options.theatre is None:
            return None
        return cls(
            options.theatre, options.shrink, options.node, not options.no_resume,
            options.structured_light,
        )  # fmt: skip

    def check(self, options: "DiveOptions") -> None:
        """Raise a UserError for a theatre that cannot be shown."""
        from subsea.stage.cluster.ticks import tick_source_maker
        from subsea.stage.setup import set_up_theatre

        display = options.display
        setup = set_up_theatre(self.name, display.mode, display.stereo, self.node)
        tick_source_maker(setup.theatre, setup.path, self.node, {})

    def plan(self, options: "DiveOptions") -> "DiveOptions":
        """Load the theatre; options for one computer are refused on a node."""
        from subsea.stage.cluster.ticks import MasterScenario
        from subsea.stage.line_up import TheatreLineUp
        from subsea.stage.setup import theatre_windows
        from subsea.stage.show_file import check_for_cluster
        from subsea.stage.theatre.load import load_theatre

        start, screens = options.start, show_of(options.parts)
        if self.node is not None and options.see_brightness:
            raise UserError(
                "--see-brightness is for one computer: others would not see the same light"
            )
        if self.node is not None and (start.follow or start.eyes or start.pace is not None):
            option = "--follow" if start.follow else "--eyes" if start.eyes else "--pace"
            raise UserError(f"{option} is for one computer: others would not go along")
        if self.node is not None and screens is not None:
            cluster = load_theatre(self.name)[0].cluster
            if cluster is not None and self.node != cluster.master:
                raise UserError(f"--playlist is for the master of the cluster, {cluster.master!r}")
            check_for_cluster(screens.show, screens.path)
        if self._light_s is not None:
            if options.display.mode != "mono":
                raise UserError("--structured-light is for one eye: drop --display")
            cluster = load_theatre(self.name)[0].cluster
            if self.node is not None and cluster is not None and self.node != cluster.master:
                message = f"--structured-light is for the master of the cluster, {cluster.master!r}"
                raise UserError(message)
            self.light.show(0 if self._light_s else 1)
        leads = any(part.leads for part in options.parts)
        shown = theatre_windows(self, options.display, leads)
        self._installation = shown.installation, shown.make_ticks
        self.line_up = TheatreLineUp(self, shown, options.display)
        self._folder = shown.setup.path.parent
        self._master = MasterScenario()
        return options

    def installation(self, options: "DiveOptions") -> "tuple[Installation, TickSourceMaker] | None":
        """The windows and the source of ticks of the theatre."""
        return self._installation

    def begin(self, dive: "Dive") -> None:
        """Let the keyboard of this computer line the projectors up, and a node follow overlays."""
        from subsea.stage.overlays import MasterOverlay

        if self.line_up is not None:
            self.line_up.listen(dive)
        if not dive.tick_source.has_pilot:
            self._overlay = MasterOverlay(self._folder, dive.note_fault)

    @property
    def light(self) -> "StructuredLight":
        """The structured light of the theatre; a UserError if it can have none."""
        if self._light is None:
            from subsea.stage.calibration.lit_theatre import lit_theatre
            from subsea.stage.calibration.photographs import light_steps
            from subsea.stage.structured_light import StructuredLight

            steps = light_steps(lit_theatre(self.name).channels, self.shrink)
            self._light = StructuredLight(steps, self._light_s or None)
        return self._light

    def before(self, dive: "Dive", elapsed_s: float) -> bool:
        """Let all computers show the line-up, and go on with structured light by the clock."""
        if self.line_up is not None:
            self.line_up.before(dive)
        if self._light is not None:
            self._light.update(elapsed_s)
        return False

    def over(self, presented: "Presented") -> "Presented":
        """Show structured light instead of the sea."""
        if self._light is None or self._light.shown is None:
            return presented
        import msgspec

        return msgspec.structs.replace(presented, light=self._light.shown)

    def cue(self) -> None:
        """Go on to the next picture of structured light, if one is shown."""
        if self._light is not None and self._light.number:
            self._light.cue()

    def ticked(self, dive: "Dive") -> None:
        """Show the line-up and the overlay of this picture; no pointer over structured light."""
        presented = dive.tick_source.presented
        dive.window_set.hide_pointer("structured light", presented.light is not None)
        if self.line_up is not None:
            self.line_up.ticked(dive)
        if self._overlay is not None:
            dive.picture.overlay = self._overlay.follow(presented.overlay)

    def shown(self, dive: "Dive") -> None:
        """Open what the master of this node has opened."""
        self._master.follow(dive)


def theatre_of(parts: Sequence[DivePart]) -> TheatrePart | None:
    """The theatre among the parts of a dive; None: the dive is in a window of its own."""
    return next((part for part in parts if isinstance(part, TheatrePart)), None)


class ShowPart(DivePart):
    """Plays a show of several scenarios."""

    leads = waits = True

    def __init__(self, path: Path, tell: Callable[[str], object] = say) -> None:
        """`path` is the file of the show; `tell` takes its messages."""
        self.path, self._tell = path, tell

    @staticmethod
    def add_options(parser: ArgumentParser) -> None:
        """Add the option that names the show."""
        parser.add_argument(
            "--playlist",
            metavar="SHOW",
            help="a show of several scenarios, by the clock or on cue: a file or a shipped show "
            "such as go-fish; see docs/how-to/show.md",
        )

    @classmethod
    def made(cls, options: Namespace, dive: "DiveOptions") -> "ShowPart | None":
        """Make the part for `--playlist`."""
        from subsea.view.display_rigs import HEADSET

        if options.playlist is None:
            return None
        shared.refuse(options, ("tour", "follow", "eyes", "fish"), "--playlist goes without {}")
        given = {word.partition("=")[0] for word in options.words}
        for name in sorted(given & {"--scenario", "--set"}):
            raise UserError(f"--playlist goes without {name}")
        if options.display == HEADSET:
            raise UserError(f"--playlist is for screens: expected no --display {HEADSET}")
        from subsea.stage.show_file import show_path

        return cls(show_path(options.playlist))

    def check(self, options: "DiveOptions") -> None:
        """Raise a UserError for the first item that cannot be shown."""
        from subsea.stage.cue_parts import check_cues
        from subsea.stage.show_file import faults, load_show

        show = load_show(self.path)
        check_cues(show, self.path)
        for _, fault in faults(show, self.path):
            raise fault

    def plan(self, options: "DiveOptions") -> "DiveOptions":
        """Read the show, which takes this part's place; the dive begins in the scenario due."""
        from subsea.stage.cue_parts import cues_of
        from subsea.stage.show_player import ShowScreens

        screens = ShowScreens(self.path, self._tell)
        mine = [part for part in (cues_of(screens), screens) if part is not None]
        parts: list[DivePart] = []
        for part in options.parts:
            parts += mine if part is self else [part]
        return replace(options, scenario=screens.first_scenario, parts=tuple(parts))


def show_of(parts: Sequence[DivePart]) -> "ShowScreens | None":
    """The show among the planned parts of a dive; None: no show is played."""
    from subsea.stage.show_player import ShowScreens

    return next((part for part in parts if isinstance(part, ShowScreens)), None)


class ConsolePart(DivePart):
    """Serves the presenter's console."""

    leads = True
    remote: "RemoteControl | None" = None  # None: it could not be opened

    def __init__(self, options: "ConsoleOptions") -> None:
        """`options` are the addresses and secrets of the console."""
        self._options = options

    @staticmethod
    def add_options(parser: ArgumentParser) -> None:
        """Add the options of the console."""
        group = parser.add_argument_group(
            "presenter's console", "a page for a tablet at the side: docs/how-to/console.md"
        )
        group.add_argument(
            "--console",
            nargs="?",
            const="127.0.0.1:8880",
            metavar="ADDRESS:PORT",
            help="serve the page there (default: 127.0.0.1:8880, for this computer only)",
        )
        group.add_argument(
            "--console-tls",
            nargs=2,
            type=Path,
            metavar=("CERTIFICATE", "KEY"),
            help="PEM files for an address that other computers reach",
        )
        group.add_argument(
            "--console-token",
            type=Path,
            metavar="FILE",
            help="file of the token that the page asks for (default: for other computers, one that "
            "is generated in the folder of the settings)",
        )
        group.add_argument(
            "--console-name",
            action="append",
            metavar="HOST",
            help="a name in the network under which the page may be called",
        )
        group.add_argument(
            "--console-osc",
            nargs="?",
            const="127.0.0.1:8881",
            metavar="ADDRESS:PORT",
            help="take commands by OSC there (default: 127.0.0.1:8881), beside the page",
        )

    @classmethod
    def made(cls, options: Namespace, dive: "DiveOptions") -> "ConsolePart | None":
        """Make the part for `--console`."""
        if options.console is None:
            shared.refuse(
                options,
                ("console-tls", "console-token", "console-name", "console-osc"),
                "dive: {} needs --console",
            )
            return None
        if options.write_unit is not None:  # which makes no token
            return None
        from subsea.base.system import require
        from subsea.stage.console.options import console_options

        require("console", "--console")
        chosen, lines = console_options(
            options.console, options.console_osc, options.console_token, options.console_tls,
            tuple(options.console_name or ()),
        )  # fmt: skip
        for line in lines:
            say(line)
        return cls(chosen)

    def begin(self, dive: "Dive") -> None:
        """Open the console; a fault, such as a port that is taken, is one line."""
        from subsea.stage.console.remote_control import open_console
        from subsea.stage.fleet_part import fleet_of

        theatre = theatre_of(dive.parts)
        line_up = None if theatre is None else theatre.line_up
        light = None if theatre is None else lambda: theatre.light
        fleet = fleet_of(dive.parts)
        self.remote = open_console(dive, self._options, show_of(dive.parts), line_up, light, fleet)

    def beat(self) -> None:
        """Note that the dive is alive."""
        if self.remote is not None:
            self.remote.beat()

    def before(self, dive: "Dive", elapsed_s: float) -> bool:
        """Apply the presenter's commands."""
        if self.remote is not None:
            self.remote.update(elapsed_s)
        return False

    def over(self, presented: "Presented") -> "Presented":
        """Show what the presenter lays over the sea."""
        return presented if self.remote is None else self.remote.presented

    def after(self, dive: "Dive") -> None:
        """Publish a small picture, if somebody looks."""
        if self.remote is not None:
            self.remote.look()

    def close(self) -> None:
        """Stop the server."""
        if self.remote is not None:
            self.remote.close()
            self.remote = None


class KioskPart(DivePart):
    """Keeps the dive of an exhibition in front, hides a resting pointer, and counts visits."""

    @staticmethod
    def add_options(parser: ArgumentParser) -> None:
        """Add the option of a kiosk."""
        parser.add_argument(
            "--kiosk",
            action="store_true",
            help="for exhibitions: full screen, only controls of visitors; Ctrl+Shift+Q quits",
        )

    @classmethod
    def made(cls, options: Namespace, dive: "DiveOptions") -> "KioskPart | None":
        """Make the part for `--kiosk`."""
        return cls() if options.kiosk else None

    def plan(self, options: "DiveOptions") -> "DiveOptions":
        """Fill the screen, go by the settings of a kiosk, and keep no changes of visitors."""
        from subsea.dive.settings import kiosk_settings

        return replace(
            options,
            kiosk=True,
            display=replace(options.display, fullscreen=True),
            settings=kiosk_settings(options.settings),
            settings_file=None,
        )

    def opened(self, dive: "Dive") -> None:
        """Let only a key of the operator close the windows."""
        from subsea.stage.show_player import DiveCount
        from subsea.ui import glfw

        self._count, self._visits = DiveCount(say), 0
        self._rested_s = self._away_s = 0.0
        for window in dive.window_set.windows:
            window.stays = True
            glfw.set_window_attrib(window.handle, glfw.AUTO_ICONIFY, False)

    def begin(self, dive: "Dive") -> None:
        """Say which key leaves."""
        say(f"a kiosk: {dive.preferences.settings.kiosk.leave} leaves it, in its window")

    def before(self, dive: "Dive", elapsed_s: float) -> bool:
        """Hide a resting pointer, take the keyboard back, and count a new visit."""
        from subsea.ui import glfw

        windows = dive.window_set.windows
        self._rested_s = 0.0 if dive.tours.active else self._rested_s + elapsed_s
        dive.window_set.hide_pointer("kiosk", self._rested_s > POINTER_S)
        away = not any(window.focused for window in windows)
        self._away_s = self._away_s + elapsed_s if away else 0.0
        if self._away_s > AGAIN_S:
            self._away_s, handle = 0.0, windows[0].handle
            if glfw.get_window_attrib(handle, glfw.ICONIFIED):
                glfw.restore_window(handle)
            glfw.focus_window(handle)
        if dive.tours.visits > self._visits:
            self._visits = dive.tours.visits
            self._count.add(date.today())
        return False


class HeadsetPart(DivePart):
    """Shows the dive in a headset."""

    @classmethod
    def made(cls, options: Namespace, dive: "DiveOptions") -> "HeadsetPart | None":
        """Make the part for `--display headset`."""
        from subsea.view.display_rigs import HEADSET

        return cls() if options.display == HEADSET else None

    def worn(self, dive: "Dive") -> Any:
        """Put the headset on; without one the dive goes on in the window."""
        from subsea.stage.headset.display import put_on

        self._looked_s, self._worn = 0.0, None
        try:
            return put_on(dive.window_set, dive.gui, dive.note)
        except UserError as fault:
            dive.note(f"{fault}; {GOES_ON}")
            return None

    def before(self, dive: "Dive", elapsed_s: float) -> bool:
        """Look for a lost headset, and begin a visit of a kiosk when it is put on."""
        self._looked_s += elapsed_s
        if dive.kiosk and dive.picture.head is None and self._looked_s >= LOOK_S:
            from subsea.stage.headset.display import put_on

            self._looked_s = 0.0
            try:
                dive.put_on(put_on(dive.window_set, dive.gui, dive.note))
            except UserError:
                return False
        if dive.kiosk and dive.picture.head is not None:
            self._attend(dive)
        return False

    def _attend(self, dive: "Dive") -> None:
        """Begin a new dive when the headset is put on; wait while it is not worn."""
        head = dive.picture.head
        if head.headset.worn == self._worn:
            return
        self._worn = head.headset.worn
        if self._worn:
            dive.tours.begin()
            dive.tick_source.set_tour(None)
            head.recentre()
        if dive.timeline is not None:
            dive.timeline.paused = not self._worn


class ServicePart(DivePart):
    """Tells the service manager how the dive does, or writes the unit that starts it."""

    def __init__(self, unit: Path | None = None) -> None:
        """`unit` is the file to write instead of a dive, of this user if it has no name."""
        from subsea.stage.service import PictureReports

        self.unit, self._reports = unit, PictureReports()

    @staticmethod
    def add_options(parser: ArgumentParser) -> None:
        """Add the option that writes a unit."""
        parser.add_argument(
            "--write-unit",
            type=Path,
            nargs="?",
            const=Path(),
            metavar="FILE",
            help="check the other options and write a systemd unit for this dive instead: "
            "docs/how-to/operating.md (default: of this user)",
        )

    @classmethod
    def made(cls, options: Namespace, dive: "DiveOptions") -> "ServicePart | None":
        """Make the part, where there is a service manager or a unit to write."""
        if options.write_unit is None and "NOTIFY_SOCKET" not in os.environ:
            return None
        return cls(options.write_unit)

    def instead(self, options: "DiveOptions", words: Sequence[str]) -> int | None:
        """Write the unit, if that was asked for."""
        if self.unit is None:
            return None
        from subsea.stage.service import write_unit

        theatre = theatre_of(options.parts)
        node = None if theatre is None else theatre.node
        out = None if self.unit == Path() else self.unit
        return write_unit(words, options, node, out)

    def shown(self, dive: "Dive") -> None:
        """Report the pictures."""
        self._reports.update(dive.pictures, dive.tick_source.waiting or dive.source.stem)

    def close(self) -> None:
        """Report that the dive ends, after a signal too."""
        from subsea.stage.service import notify

        notify(STOPPING=1)
