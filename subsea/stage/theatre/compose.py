"""The commented theatre file of a layout, and the steps to line its projectors up."""

import textwrap
from typing import Any

import numpy as np

from subsea.base.toml_edit import toml_value
from subsea.stage.theatre.layouts import TheatreLayout
from subsea.stage.theatre.theatre_writer import plain

IN_A_ROW = 6  # windows of a row of the desktop
COLUMN = 98  # of comments


def mesh_name(stem: str, channel: str) -> str:
    """The name of the mesh file of a channel, beside the theatre file with this stem."""
    return f"{stem}-{channel}.data"


def compose_theatre(
    layout: TheatreLayout, stem: str, size: tuple[int, int], computers: bool, command: str
) -> str:
    """The text of a theatre file; `size` is that of every window, `command` made it.

    With `computers` each window is on a node of its own, and the middle one is the master.
    """
    names = [channel.name for channel in layout.channels]
    lines = [f"# {layout.title}. Made by:", f"#   {command}"]
    lines += [f"# {note}." for note in layout.notes]
    lines += ["#"]
    for number, step in enumerate(line_up(layout, computers), 1):
        lines += textwrap.wrap(f"# {number}. {step}", COLUMN, subsequent_indent="#   ")
    lines += ["", f'title = "{layout.title}"']
    lines += ["eye_cm = [0, 0, 0]  # the best seat; lengths count from here: right, up, ahead"]
    if layout.dome is not None:
        lines += ["level = true  # the rim of a dome shows any tilt of the horizon"]
    for number, name in enumerate(names):
        row, column = divmod(number, IN_A_ROW)
        lines += ["", "[[window]]", f'name = "{name}"']
        lines += [f'node = "{name}"'] * computers
        lines += [f"size = {list(size)}"]
        place = [0, 0] if computers else [column * size[0], row * size[1]]
        lines += [f"position = {place}  # or `monitor = {1 if computers else number + 1}`"]
    for channel in layout.channels:
        lines += ["", "[[channel]]", f'name = "{channel.name}"', f'window = "{channel.name}"']
        lines += [f"{type(channel.screen).__name__.lower()} = {_toml(channel.screen)}"]
        if layout.blend and len(names) > 1:
            lines += ["blend = true", "gamma = 2.2  # of the projector", "black = 0.0"]
        if channel.nodes is not None:
            lines += [f'warp = "{mesh_name(stem, channel.name)}"']
    lines += ["", "# Only for `subsea theatre FILE --picture`.", "[room]"]
    lines += [f"floor_cm = {_toml(layout.floor_cm)}"]
    if layout.dome is not None:
        lines += [f"dome = {_toml(layout.dome)}"]
    if layout.mirror is not None:
        lines += [f"mirror = {_toml(layout.mirror)}"]
    lines += ["", "[room.projectors]  # places of the lenses"]
    lines += [f"{channel.name} = {_toml(channel.lens.place)}" for channel in layout.channels]
    if computers:
        lines += ["", "# One computer shows all nodes as it stands. For several enter the master's"]
        lines += ["# own address, make keys with"]
        lines += [f'# `subsea keys keys {" ".join(names)}`, and add `keys = "keys"`.']
        lines += ["[cluster]", f'master = "{names[len(names) // 2]}"', 'address = "127.0.0.1:5560"']
    return "\n".join(lines) + "\n"


def line_up(layout: TheatreLayout, computers: bool) -> list[str]:
    """The steps to line up the projectors of a layout, in their order."""
    warped = any(channel.nodes is not None for channel in layout.channels)
    blended = layout.blend and len(layout.channels) > 1
    steps = ["Fix each projector at its place under [room.projectors]. Switch off keystone, zoom "
             "modes and dynamic contrast; let it warm up for half an hour."]  # fmt: skip
    if layout.mirror is not None:
        steps += ["Fix the mirror at its place under [room]. The front surface must reflect. "
                  "Set focus at the middle of the dome."]  # fmt: skip
    steps += ["Measure the screen: corners, radius or angles, in centimetres from the best seat. "
              "Correct the channels below, then run `subsea theatre FILE`."]  # fmt: skip
    steps += [
        "Dive with `subsea dive --theatre FILE` and press T for the test pattern. The white "
        "edge of each picture must be complete, and numbers must stand in their places."
    ]
    if warped:
        steps += [
            "Move each projector until its pattern fits: first its middle, then its size, "
            "then its corners. The meshes hold for the places of the lenses in this file; "
            "for others make them again with these places, or with a calibration camera."
        ]
    else:
        steps += [
            "Move each projector until its pattern fits the measured corners: first its "
            "middle with lens shift, then its size with zoom. Circles must be round."
        ]
    if blended:
        steps += [
            "Compare the patterns of neighbours where they overlap: lines must meet within "
            "a pixel or two at eye level, then at the top and the bottom."
        ]
        steps += [
            "Press T again. If the overlap is brighter than the rest in all scenes, lower "
            "`gamma`; if it is darker, raise it."
        ]
        steps += ["In a dark room show a dark scene. If overlaps are grey strips, raise `black` "
                  "in steps of 0.001."]  # fmt: skip
    if computers:
        steps += ["Start the other computers first, each with `--node NAME`, then the master."]
    return steps


def _short(value: Any) -> Any:
    """Round numbers to a thousandth, whole ones without a point."""
    if isinstance(value, dict):
        return {key: _short(inner) for key, inner in value.items()}
    if isinstance(value, list | np.ndarray):
        return [_short(inner) for inner in value]
    number = round(float(value), 3)
    return int(number) if number.is_integer() else number


def _toml(value: Any) -> str:
    return toml_value(_short(plain(value)))
