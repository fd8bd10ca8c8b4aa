"""Every command that a page of the documentation tells to type is read by its parser.

At night it is typed, too, in a short form.

In this process, in a folder with all that pages take for granted: a photograph, a record, a sea, a
theatre, a fish of one's own. Seas are small and pictures tiny; what else is short is in `SHORT`. A
command that stands in a sentence without what it needs (`subsea film`) is read by its parser; so is
an example of `commands.md`, which comes last, if it has nothing that was not typed before.
"""

import argparse
import os
import re
import runpy
import shlex
import shutil
import socket
import subprocess
import sys
from collections import deque
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from functools import cache
from io import StringIO
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from dask import config as _  # noqa: F401  (before distributed, which asks for it)
from distributed.cli import dask_scheduler, dask_worker
from PIL import Image

from capture.cli import main as capture_cli
from capture.flat import films, lessons
from capture.inspection import gait as timing
from subsea.base.command_line import parse_arguments
from subsea.base.errors import UserError
from subsea.base.system import ROOT, resource_names
from subsea.cli import main
from subsea.dive.settings import read_settings
from subsea.export import skinning
from subsea.fish.species import load_species, shipped_species
from subsea.lab import paper_tables
from subsea.repertoire import BASIC_SEGMENTS, read_repertoire, write_repertoire
from subsea.scenario.load import load_scenario
from subsea.stage.cluster.master import WaitStatistics
from subsea.stage.show_file import load_show
from subsea.stage.theatre.load import load_theatre
from subsea.studio.fitting import silhouette
from subsea.studio.side_view import centred_matrix
from subsea.ui.window_set import WindowSet
from tests.support import theatre_samples
from tests.support.pages import PAGES, PROGRAMS, Command, blocks, inline, prose, steps
from tests.support.recording import forget_turns

pytestmark = pytest.mark.timeout(900)  # a page of many commands may compile all kernels

# Commands that are not typed here, by their beginnings, and why.
NOT_TYPED = {
    ".venv/bin/python -m pytest": "this test runs in it",
    ".venv/bin/ruff": "`make test` begins with it",
    ".venv/bin/mypy": "`make test` does that",
    ".venv/bin/uv lock": "it asks the network",
    ".venv/bin/jupyter": "tests/docs/test_notebooks.py runs the notebooks",
    "pip install": "it asks the network",
    "python -m http.server": "it serves until it is interrupted",
    "python tools/blender_scene.py": "`make blender` runs it, in Blender's own Python",
    "uvx": "it asks the network",
    ". .venv/bin/activate": "these programs run in it already",
    "apt install": "it asks the network",
    "export SIMULATED_ENABLE=1": "it is for the next line",
    "monado-service": "there is no runtime of headsets",
    "python -m tools.check_headset_dive": "there is no runtime of headsets",
    "subsea theatre --new --out": "it asks on a terminal; test_theatre_plan.py answers",
    "subsea theatre FILE --calibrate": "tests/stage/calibration has photographs",
    "subsea theatre dome6.toml --calibrate": "tests/stage/calibration has photographs",
    "subsea dive --theatre dome6-calibrated.toml": "tests/stage/calibration has photographs",
    "subsea soak --kiosk": "it takes minutes; tests/stage/test_kiosk_soak.py runs it",
    ".venv/bin/subsea soak --kiosk": "it takes minutes; tests/stage/test_kiosk_soak.py runs it",
    "openssl req": "tests/console makes a certificate so",
    "curl": "it asks a dive that goes on",
    "subsea dive --console 0.0.0.0:8880": "it listens to other computers; tests/console does that",
    "subsea dive --stream rtp://239.10.10.1:5004": "it sends to other computers",
    "subsea fleet": "it needs nodes; tests/stage/fleet has some",
    "systemctl --user": "there is no desktop with systemd",
    "journalctl --user": "there is no desktop with systemd",
    "subsea-capture record --all --cluster": "tests/capture has a cluster",
    "subsea sweep peaceful --seeds 1:4 --csv --out sweep --cluster": "tests/jobs has a scheduler",
    "dask scheduler --protocol tls": "the same",
    "dask worker tls://HOST:8786": "the same",
    "subsea-capture fit": "it takes minutes; tests/capture/learning/test_fit.py runs it",
    "subsea-capture learn --body": "it takes minutes to an hour; tests/capture/learning runs it",
}
# Replacements of words in capitals. Later ones are for what is left by those before.
STANDS_FOR = (
    (r"\[SPECIES\]", "my_fish"),
    (r"--scenario NAME", "--scenario preying"),
    (r"--theatre NAME", "--theatre three-projectors"),
    (r"--(theatre|node) FILE", r"--\1 hall.toml"),
    (r"theatre FILE", "theatre hall.toml"),
    (r"show FILE", "show show.toml"),
    (r"--node NAME", "--node middle"),
    (r"--tour NAME", "--tour reef"),
    (r"--settings FILE", "--settings my_settings.toml"),
    (r"\b(FILE|RECORD)\.h5", "run.h5"),
    (r"mesh FILE", "mesh my_fish"),
    (r"\bMESH\.obj", "sardine.obj"),
    (r"\bOUT\.mp4", "film.mp4"),
    (r"film OUT\b", "film pictures"),
    (r"\b(SPECIES|NAME)\b", "my_fish"),
    (r"\bFISH\b", "1"),
    (r"\bPHOTO\b", "guppy.jpg"),
    (r"\bKEY=VALUE", "seed=2"),
    (r"--out DIR", "--out made"),
    (r"\b(OUT|FOLDER|CHECKOUT)\b", "folder"),
    (r"\bSCENARIO\b", "peaceful"),
    (r"\bHOST\b", "127.0.0.1"),
    (r"\bSCRIPT\b", "make_pictures.py"),
    (r"\bN\b", "2"),
)
# Options that come after those of the page, and so count in their place.
SHORT = {
    "subsea dive": "--seconds 0.1",
    "subsea film": "--seconds 0.05 --quality low",
    "subsea simulate": "--ticks 4",
    "subsea sweep": "--jobs 1 --seeds 1 --seconds 2",
    "subsea dataset": "--jobs 1 --images 2 --size 64x64 --quality low",
    "subsea benchmark": "--frames 1 --quality low",
    "subsea soak": "--minutes 0.01",
    "subsea-capture flat": "--quick --only integrators",
    "subsea-capture learn": "--budget 2 --only swim",
    "subsea-capture export": "--detail 3",
    "subsea export": "--start 0 --seconds 0.1 --detail 3 --with none --fish 4",
}
MAY_FAIL = {  # nothing better be learned, a busy machine be slow, no GPU be there
    "subsea-capture learn": (0, 1),
    "subsea-capture inspect": (0, 1),
    "subsea doctor": (0, 1),
}
PROGRAMS_OF_OURS = {"subsea": main, "subsea-capture": capture_cli}
NEED_MORE = ["subsea", "study"], ["subsea-capture", "learn"]  # records, or a species
COMMANDS = "commands.md"  # its examples are made from the programs' own help
WINDOWS = "subsea build", "subsea skin"  # which a hand would close
SEAS = "dive", "film", "simulate", "benchmark", "soak"

# Pages whose blocks of TOML without a file name are read, by their reader.
SEA_PAGES = "scenarios.md", "directing.md", "builder.md"
SETTINGS_PAGES = ("settings.md",)
THEATRE_PAGES = "theatre-file.md", "cluster.md", "fleet.md"
SHOW_PAGES = ("show.md",)

SEA = """
title = "A small sea"
seed = 1
simulated = 2
bounds = { radius_cm = 900.0, depth_cm = 500.0 }
water = { fog = [0.006, 0.072, 0.180], visibility_cm = 1500.0 }
terrain = { dune_height_cm = 0.0, dune_length_cm = 600.0 }
submarine = { position_cm = [-480.0, -60.0, -250.0] }
[[fish]]
species = "moon_wrasse"
number = 60
[[fish]]
species = "emperor_angelfish"
number = 2
[[fish]]
species = "clownfish"
number = 2
[[tour]]
name = "reef"
waypoint = [
    { time_s = 0.0, position_cm = [300.0, -300.0, -250.0], ahead = true },
    { time_s = 4.0, position_cm = [300.0, -100.0, -250.0] },
]
[[direction]]
camera = { position_cm = [300.0, -300.0, -250.0], look_at_cm = [0.0, 0.0, -250.0], over_s = 0.0 }
[[direction]]
at_s = 0.1
end = true
"""
TRIANGLE = "v 0 0 0\nv -10 2 0\nv -10 -2 1\nf 1 2 3\n"


class Parsed(Exception):  # noqa: N818
    """The command line of a script was read."""


class Workshop:
    """The folder in which commands are typed, and which of them have been."""

    def __init__(self, folder):
        self.folder, self.done = folder, set()
        for name in ("assets", "repertoires"):
            (folder / name).symlink_to(ROOT / name)
        (folder / "docs").mkdir()
        for name in ("studies", "outlines"):
            (folder / "docs" / name).symlink_to(ROOT / "docs" / name)
        for name in ("made", "my", "some", "kept"):
            (folder / name).mkdir()
        (folder / "sea.toml").write_text(SEA)
        (folder / "show.toml").write_text('[[item]]\nscenario = "sea.toml"\n')
        (folder / "my.toml").write_text(SEA)
        (folder / "my_settings.toml").write_text("[mouse]\nsteer = false\n")
        (folder / "sardine.obj").write_text(TRIANGLE)
        photograph = self._photograph()
        for name in ("guppy.jpg", "fish.jpg", "clown.png"):
            photograph.convert("RGBA" if name.endswith("png") else "RGB").save(folder / name)
        self._species(folder / "home/.local/share/subsea")
        for path in (ROOT / "repertoires").glob("*.h5"):
            shutil.copy2(path, folder / "kept")
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        theatre = (ROOT / "assets/theatres/three-computers.toml").read_text()
        for name in ("hall.toml", "my/theatre.toml"):
            (folder / name).write_text(theatre.replace("5560", str(port)))
        (folder / "planetarium.json").write_bytes(theatre_samples.text(theatre_samples.sgct()))

    @staticmethod
    def _photograph():
        plan = load_species("moon_wrasse").surface
        mask = silhouette(plan, centred_matrix(140, 96, plan), (96, 140))
        pixels = np.full((96, 140, 4), (230, 120, 30, 255), np.uint8)
        pixels[~mask] = (0, 0, 255, 0)
        return Image.fromarray(pixels)

    def _species(self, own):
        (own / "species").mkdir(parents=True)
        (own / "repertoires").mkdir()
        for name in ("my_fish", "my_guppy", "my_tuna"):
            shutil.copy(ROOT / "assets/species/moon_wrasse.toml", own / f"species/{name}.toml")
            motion = replace(read_repertoire(ROOT / "repertoires/moon_wrasse.h5"), species=name)
            write_repertoire(own / f"repertoires/{name}.h5", motion)
        shutil.copy(ROOT / "assets/species/moon_wrasse.toml", own / "species/few.toml")
        few = {name: motion.segments[name] for name in BASIC_SEGMENTS}
        write_repertoire(own / "repertoires/few.h5", replace(motion, species="few", segments=few))
        shutil.copy(ROOT / "assets/species/moon_wrasse.toml", self.folder / "some/fish.toml")
        shutil.copy(self.folder / "some/fish.toml", self.folder / "my_fish.toml")

    def take(self, step, only_read=False):
        """Type a command, save a file, or run a block of Python; an AssertionError if it fails."""
        if isinstance(step, Command):
            self.type(step, only_read)
        elif step.kind == "python":
            text = re.sub(r"\b(step|range)\(\d{3,}\)", r"\1(30)", step.text)  # shorter
            code = compile(text, step.page, "exec")
            if not only_read:
                with redirect_stdout(StringIO()):
                    exec(code, {})
        elif step.kind == "text":
            for line in step.text.splitlines():
                if line.startswith("subsea: "):
                    assert said_again(line) == line
        elif found := re.match(r"# ([\w.]+\.toml)(, at its end)?\n", step.text):
            with (self.folder / found[1]).open("a" if found[2] else "w") as file:
                file.write(step.text)
        else:
            read_toml(step, self.folder)

    def type(self, command, only_read):
        """Type a command, in its short form, or only read it."""
        if any(f"{command.text} ".startswith(f"{one} ") for one in NOT_TYPED):
            return
        text = command.text
        for pattern, word in STANDS_FOR:
            text = re.sub(pattern, word, text)
        words = shlex.split(text, comments=True)
        words[0] = words[0].removeprefix(".venv/bin/")
        if words[:2] == ["python", "-m"]:
            words[:3] = [{"subsea": "subsea", "capture": "subsea-capture"}[words[2]]]
        if words[0] in ("subsea", "subsea-capture"):
            repeated = command.page == COMMANDS and self.repeated(words)
            self.run(words, command.inline, only_read or repeated)
        elif words[0] == "python":
            script(words[1:])
        elif words[0] == "make":
            self.make(words, only_read)
        elif words[0] == "dask":
            part = {"scheduler": dask_scheduler, "worker": dask_worker}[words[1]]
            part.main.make_context(words[1], words[2:])
        elif words[0] in ("mkdir", "cp", "sed", "echo", "chmod"):
            subprocess.run(["sh", "-c", command.text], check=True)
        else:
            raise AssertionError(
                "nobody knows how to type this: teach Workshop.type in "
                "tests/docs/test_every_command.py, or say in NOT_TYPED why it is not typed"
            )

    def make(self, words, only_read):
        """Check the targets of `make`, and run the dive that it opens."""
        subprocess.run(
            ["make", "-C", str(ROOT), "--dry-run", "--always-make", *words[1:]],
            check=True, capture_output=True,
        )  # fmt: skip
        if words[1] == "run":
            given = [word.removeprefix("ARGS=") for word in words[2:]]
            self.run(["subsea", "dive", *shlex.split(" ".join(given))], False, only_read)

    def repeated(self, words):
        """True if a command has been typed with each of these options, maybe not at once."""
        like = [options_in(done) for done in self.done if list(done[:2]) == words[:2]]
        if "--json" in words:  # another command may read the report
            return False
        return bool(like) and options_in(words) <= set().union(*like)

    def run(self, words, inline, only_read=False):
        """A command of one of the programs; `only_read` by its parser."""
        program = PROGRAMS_OF_OURS[words[0]]
        if len(words) == 1 or (inline and words in NEED_MORE):
            return
        if words[1:] == ["--version"]:
            with pytest.raises(SystemExit, match="0"):
                program.main(words[1:])
            return
        parser, commands = program.parsers()
        try:
            parse_arguments(parser, commands, words[1:])
        except UserError as fault:
            if not (inline and re.search("(is|are) required|expected one argument", str(fault))):
                raise
            parse_arguments(*relaxed(*program.parsers()), words[1:])
            return
        if only_read:
            return
        words = shortened(words)
        if tuple(words) in self.done:
            return
        self.done.add(tuple(words))
        shutil.rmtree(self.folder / "pictures", ignore_errors=True)
        name = " ".join(words[:2])
        told = StringIO()
        with redirect_stdout(told), pytest.MonkeyPatch.context() as patch:
            if (name in WINDOWS and "--auto" not in words) or "--node" in words:
                patch.setattr(WindowSet, "present", closing(WindowSet.present))
            code = program.main(words[1:])
        allowed = (130, 0) if name in WINDOWS or "--node" in words else MAY_FAIL.get(name, (0,))
        assert code in allowed, f"exit code {code} of {shlex.join(words)}\n{told.getvalue()}"


def options_in(words):
    """The options of a command."""
    return {word.partition("=")[0] for word in words if word.startswith("-")}


def closing(present):
    """`WindowSet.present` that is interrupted, as by Ctrl-C, when a second picture was shown."""
    shown = []

    def close(wall):
        present(wall)
        shown.append(wall)
        if len(shown) == 2:
            raise KeyboardInterrupt

    return close


def relaxed(parser, commands):
    """The parser with nothing required, and options that may stand without a value."""
    for command in commands.choices.values():
        for group in command._mutually_exclusive_groups:
            group.required = False
        for action in command._actions:
            action.required = False
            if action.nargs in (None, "+"):
                action.nargs = "?" if action.option_strings else "*"
            if not action.option_strings:
                action.choices = None
    return parser, commands


def shortened(words):
    """A command with options that make it short, and in the small sea.

    Scenarios by name are only looked up; those of a file are what the page is about.
    """
    program, name = words[:2]
    short = shlex.split(SHORT.get(f"{program} {name}", ""))
    if name in ("simulate", "sweep") and "--seconds" in words:  # in place of --ticks
        short = [*(short if name == "sweep" else []), "--seconds", "0.2"]
    if "--validate" in words:
        words = [word for word in words if word not in resource_names("assets/scenarios", ".toml")]
        short = ["sea.toml", "--seeds", "1", "--seconds", "0.2", "--jobs", "1"]
    if program == "subsea" and name in SEAS and "--paper" not in words:
        chosen = words[words.index("--scenario") + 1] if "--scenario" in words else "peaceful"
        if not chosen.endswith(".toml") and "--playlist" not in words:
            assert chosen in resource_names("assets/scenarios", ".toml"), chosen
            short += ["--scenario", "sea.toml"]
        if "--theatre" in words:
            short += ["--shrink", "16"]
        elif name in ("dive", "film", "benchmark"):
            short += ["--size", "64x64"]
        if "--fish" in words:
            ladder = "," in words[words.index("--fish") + 1] and name == "benchmark"
            short += ["--fish", "4,5" if ladder else "4"]
    if "--paper" in words:
        short = []
    if program == "subsea-capture":
        if name == "plot" and len(words) > 2:  # a page of each segment takes a minute
            words = [*words[:2], "few.h5", *words[3:]]
        if "--gait" in words or "--body" in words:
            short = ["--budget", "2"]
        if words[1:3] == ["learn", "fusilier"] or ("--out" in words[:-1] and name == "learn"):
            short += ["--out", "learned.toml"]
        if name == "export" and words[2] in shipped_species():
            words = [*words[:2], "few", *words[3:]]
        if name == "record":
            words = words if len(words) > 2 else [*words, "--all"]
            short += ["--out", "kept"] if words[2] in [*shipped_species(), "--all"] else []
    return [*words, *short]


def said_again(line):
    """The program's output where a page shows `line`."""
    if found := re.match(
        r"subsea: node (\w+): (\d+) pictures, waited for (\S+) .*p95 (\S+) .*most (\S+)", line
    ):
        name, frames = found[1], int(found[2])
        mean, late, most = (float(number) / 1e3 for number in found.groups()[2:])
        counts = {word: line.count(f"{word} once") for word in ("dropped", "rejoined")}
        waits = WaitStatistics(frames, frames * mean, most, deque([late]), **counts)
        return f"subsea: node {name}: {waits.words()}"
    if found := re.match(
        r"subsea: (my\.toml):(\d+): unknown key `(\w+)`, at `direction\[1\]`", line
    ):
        before, fishes = SEA.split("[[fish]]", 1)
        directions = f"[[direction]]\nat_s = 1.0\n[[direction]]\n{found[3]} = 1\n"
        gap = "\n" * (int(found[2]) - before.count("\n") - 4)
        Path(found[1]).write_text(f"{before}{gap}{directions}[[fish]]{fishes}")
        with redirect_stderr(StringIO()) as told:
            main.main(["film", "scene.mp4", "--scenario", found[1]])
        return told.getvalue().splitlines()[-1]
    raise AssertionError("nobody knows how to have this said: teach said_again")


def window(name):
    """A window of a theatre, on a computer of its own."""
    return (
        f'[[window]]\nname = "{name}"\nnode = "{name}"\nsize = [64, 64]\n'
        f'[[channel]]\nname = "{name}"\nwindow = "{name}"\npanorama = {{ angle_deg = 90.0 }}\n'
    )


def read_toml(block, folder):
    """Read a block of a file as the program does, with what it takes for granted before it."""
    path = folder / "block.toml"
    if block.page in SEA_PAGES:
        base = (ROOT / "assets/scenarios/rendezvous.toml").read_text().partition("[[direction]]")[0]
        text = block.text.replace("moor_clownfish", "my_fish")
        text += "[hook]\nposition_cm = [0.0, 0.0]\ndepth_cm = 200.0\n" if "hook = " in text else ""
        named, after = (
            set(re.findall(f'^{key} = "(.*)"', text, re.M)) for key in ("name", "after")
        )
        text += "".join(f'[[direction]]\nname = "{name}"\n' for name in after - named)
        path.write_text(base + text)
        load_scenario(str(path))
    elif block.page in THEATRE_PAGES:
        others = ("middle", "right") if "[cluster]" in block.text else ("left", "right")
        if "[[channel]]" not in block.text:
            windows = "".join(window(name) for name in others)
            windows = windows if "[cluster]" in block.text else re.sub("node = .*", "", windows)
            path.write_text(block.text + windows)
        else:
            path.write_text(block.text)
        load_theatre(str(path))
    elif block.page in SHOW_PAGES:
        path.write_text(block.text)
        load_show(path)
    else:
        assert block.page in SETTINGS_PAGES, "nobody knows what reads this: teach read_toml"
        path.write_text(block.text)
        read_settings(path)


def script(words):
    """Import a script of the project, and let it read its command line."""
    path = ROOT / words[0]
    source = path.read_text(encoding="utf-8")
    if path.name == "run_submarine.py":
        return  # `subsea dive`, with these words: tests/cli/test_main.py
    asks = "sys.argv", "argparse", "output_folder"
    assert len(words) == 1 or any(one in source for one in asks), "it takes nothing"

    def read(parser, arguments=None, namespace=None):
        parse_args(parser, arguments, namespace)
        raise Parsed

    parse_args = argparse.ArgumentParser.parse_args
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(argparse.ArgumentParser, "parse_args", read)
        patch.setattr(sys, "argv", [str(path), *words[1:]])
        patch.syspath_prepend(path.parent)
        if "argparse" not in source:
            runpy.run_path(str(path), run_name="imported")
            return
        with pytest.raises(Parsed):
            runpy.run_path(str(path), run_name="__main__")


@pytest.fixture(scope="module")
def workshop(display, tmp_path_factory, known_repertoire, known_turns):
    folder = tmp_path_factory.mktemp("workshop")
    home = folder / "home"
    home.mkdir()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(
            "XDG_CACHE_HOME", os.environ.get("XDG_CACHE_HOME", str(Path.home() / ".cache"))
        )
        patch.setenv("HOME", str(home))
        patch.setenv("XDG_CONFIG_HOME", str(home / ".config"))
        patch.delenv("XDG_DATA_HOME")
        patch.chdir(folder)
        for name, small in (("SIMULATED_TICKS", 20), ("PLAYED_TICKS", 3), ("REDUCED_PICTURES", 1)):
            patch.setattr(paper_tables, name, small)
        patch.setattr(paper_tables, "SIZE", (160, 120))
        patch.setattr(paper_tables, "SCENARIO", "sea.toml")
        patch.setattr(paper_tables, "RENDERED", ("sea.toml",))
        patch.setattr(paper_tables, "PLAYED_FISH", 20)
        patch.setattr("subsea.lab.benchmark.WARM_UP_FRAMES", 1)
        patch.setattr("subsea.biomechanics.trial.MIN_WARM_UP", 2)
        patch.setattr("subsea.biomechanics.trial.CLOSURE_GOAL", 1e-3)
        patch.setattr("capture.inspection.simulated.STEADY_BEATS", 2)
        patch.setattr(timing, "STEPS", 4)
        patch.setattr(timing, "FRAMES", 40)
        patch.setattr(skinning, "ROUNDS", 1)
        patch.setattr(lessons, "QUICK", lessons.Effort(1, 2, 1, 2, 1, 1, 1))
        draw = films.pictures
        patch.setattr(films, "pictures", lambda *scenes: islice(draw(*scenes), 2))
        made = Workshop(folder)
        made.run(shlex.split("subsea simulate --ticks 4 --out run.h5"), inline=False)
        few = {"swim_fast": known_repertoire.segments["swim_fast"]}
        write_repertoire(folder / "few.h5", replace(known_repertoire, segments=few))
        yield made
    forget_turns()  # which began in less steady beats


@pytest.mark.parametrize("page", sorted(PAGES, key=lambda page: page == COMMANDS))
def test_all_that_a_page_tells_to_do_can_be_done(workshop, page, capsys, pytestconfig):
    folder = workshop.folder
    only_read = not pytestconfig.getoption("--nightly")
    for name in ("keys", "seen"):  # other pages have others
        shutil.rmtree(folder / name, ignore_errors=True)
    (folder / "my.toml").write_text(SEA)
    if page == "first-fish.md" and not (folder / "lagoon.toml").exists():
        for step in blocks("first-dive.md"):  # which comes before it
            if step.kind == "toml":
                workshop.take(step)
    failed = []
    for step in steps(page):
        capsys.readouterr()
        try:
            workshop.take(step, only_read)
        except (Exception, SystemExit) as fault:
            what = step.text if isinstance(step, Command) else step.kind
            said = capsys.readouterr().err.strip().splitlines()[-3:]
            failed.append(f"{page}:{step.line}: `{what}`: {type(fault).__name__}: {fault} {said}")
    assert not failed, "\n".join(failed)


@pytest.mark.nightly
def test_the_tutorials_make_all_files_that_they_promise(workshop):
    for page, made in (
        ("first-dive.md", "lagoon.mp4"),
        ("first-fish.md", "jewel/reef_jewel.glb"),
        ("first-study.md", "school-4.h5"),
    ):
        if not (workshop.folder / made).exists():  # this test was selected alone
            for step in steps(page):
                workshop.take(step)
        assert (workshop.folder / made).exists(), made
    own = workshop.folder / "home/.local/share/subsea"
    assert (own / "repertoires/reef_jewel.h5").exists()
    assert 'name = "Reef jewel"' in (own / "species/reef_jewel.toml").read_text()


SCRIPTS = "docs", "tools"  # folders


def test_every_option_that_a_page_names_is_one():
    known = {"--regenerate", "--nightly", "--now", "--user"}  # of pytest here, and of systemctl
    known |= {"--execute", "--inplace"}  # of jupyter
    for program in (main, capture_cli):
        parser, commands = program.parsers()
        for one in (parser, *commands.choices.values()):
            known.update(name for action in one._actions for name in action.option_strings)
    for path in (path for folder in SCRIPTS for path in (ROOT / folder).glob("*.py")):
        known.update(re.findall(r'"(--[a-z-]+)"', path.read_text(encoding="utf-8")))
    assert "--budget" in known - options_of("subsea film OUT --budget 4", known)
    for page in PAGES:
        for line, text in inline(page):
            there = options_of(text, known)
            for option in re.findall(r"(?<![\w-])--[a-z][a-z-]*", text):
                assert option in there, f"{page}:{line}: nothing has {option} of `{text}`"


@cache
def read_only_parsers(name):
    """The parser of a program and those of its commands, which nobody may change."""
    return PROGRAMS_OF_OURS[name].parsers()


def options_of(text, known):
    """The options of the command with which a text begins; those that are known otherwise."""
    name, command = [*text.removeprefix(".venv/bin/").split(), "", ""][:2]
    if name not in PROGRAMS_OF_OURS or command in ("", "COMMAND"):
        return known
    parser, commands = read_only_parsers(name)
    chosen = parser if command.startswith("-") else commands.choices[command]
    return {option for action in chosen._actions for option in action.option_strings}


def test_what_is_not_typed_is_in_some_page():
    typed = [step.text for page in PAGES for step in steps(page) if isinstance(step, Command)]
    for one in NOT_TYPED:
        assert any(f"{text} ".startswith(f"{one} ") for text in typed), (
            f"no page has `{one}` any more"
        )


def test_no_two_pages_have_one_name():
    """Else one would hide the other from all tests of pages."""
    names = [path.name for path in (ROOT / "docs").rglob("*.md")]
    assert len(names) == len(set(names))


def test_every_block_says_what_it_is():
    kinds = "sh", "toml", "python", "text", "ini", "bibtex", "glsl", "js"
    for page in PAGES:
        for block in blocks(page):
            assert block.kind in kinds, f"{page}:{block.line}: expected ```sh, ```toml, ```text …"
        for line in prose(page).splitlines():
            indented = re.match(r" {4,}(?=\S)", line)
            assert not (indented and PROGRAMS.match(line[indented.end() :])), (
                f"{page}: ```sh: {line}"
            )
