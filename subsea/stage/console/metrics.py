"""Figures of a dive and of its computers and projectors, as Prometheus reads them."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

INFO = "version", "protocol", "system", "renderer"
OF_NODES: dict[str, tuple[str, str, float]] = {
    "temperature_celsius": ("highest of the computer's sensors", "temperature_c", 1.0),
    "free_disk_bytes": ("of the disk with the user's files", "free_disk_gb", 1e9),
    "frame_seconds": ("mean time from picture to picture", "frame_ms", 1e-3),
    "longest_frame_seconds": ("longest time from picture to picture", "longest_ms", 1e-3),
    "up_seconds": ("since the start of the node's dive", "up_s", 1.0),
    "seen_timestamp_seconds": ("when the node was connected last", "seen", 1.0),
    "fault_timestamp_seconds": ("when the node had its last fault", "fault_at", 1.0),
}
"""Name of each gauge of nodes, its meaning, its key, and its unit in that of the key."""
Labels = Mapping[str, object]
Sample = tuple[Labels, float | int]


def metrics(health: dict[str, Any], alive: bool, frame_age_s: float) -> str:
    """Write the figures of a dive; one that is unknown is left out."""
    last_fault, refusal = health.get("fault") or {}, health.get("refusal") or {}
    loading = health.get("loading")
    known = {
        "alive": ("1 if a picture was drawn within ten seconds", int(alive)),
        "frame_age_seconds": ("since the last picture", frame_age_s),
        "up_seconds": ("since the start of the dive", health.get("up_s")),
        "pictures_per_second": ("shown", health.get("pictures_a_s")),
        "loading": ("1 while a scenario is opened", None if loading is None else int(loading)),
        "fault_age_seconds": ("since the last fault", last_fault.get("ago_s")),
        "refusal_age_seconds": ("since the last command was refused", refusal.get("ago_s")),
    }
    lines: list[str] = []
    for name, (about, value) in known.items():
        if value is not None and value != float("inf"):
            lines += gauge(name, about, [({}, value)])
    if nodes := health.get("nodes"):
        steps = [({"node": node}, int(at)) for node, at in nodes.items()]
        lines += gauge("node_in_step", "1 if a node draws every picture", steps)
    if fleet := health.get("fleet"):
        lines += [*_of_nodes(fleet["nodes"]), *_of_projectors(fleet["projectors"])]
    return "\n".join(lines) + "\n"


def gauge(name: str, about: str, samples: Sequence[Sample]) -> Iterator[str]:
    """Write the lines of a gauge; none without samples."""
    if samples:
        yield f"# HELP subsea_{name} {about}"
        yield f"# TYPE subsea_{name} gauge"
    for labels, value in samples:
        told = ",".join(f'{key}="{_escaped(str(text))}"' for key, text in labels.items())
        yield f"subsea_{name}{{{told}}} {value}" if told else f"subsea_{name} {value}"


def _of_nodes(nodes: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    connected: list[Sample] = [({"node": one["name"]}, int(one["connected"])) for one in nodes]
    yield from gauge("node_connected", "1 if a node is connected to the master", connected)
    known = [one for one in nodes if one["version"] is not None]
    about: list[Sample] = [
        ({"node": one["name"], **{key: one[key] for key in INFO}}, 1) for one in known
    ]
    yield from gauge("node_info", "program and computer of a node", about)
    for name, (meaning, key, unit) in OF_NODES.items():
        samples: list[Sample] = [
            ({"node": one["name"]}, unit * one[key]) for one in nodes if one[key] is not None
        ]
        yield from gauge(f"node_{name}", meaning, samples)


def _of_projectors(projectors: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    answers: list[Sample] = [
        ({"projector": one["name"]}, int(not one["fault"])) for one in projectors
    ]
    yield from gauge("projector_answers", "1 if a projector answers", answers)
    power: list[Sample] = [
        ({"projector": one["name"], "power": one["power"]}, 1) for one in projectors
    ]
    yield from gauge("projector_power", "state of a projector's power", power)
    lamps: list[Sample] = [
        ({"projector": one["name"], "lamp": number}, lamp["hours"])
        for one in projectors
        for number, lamp in enumerate(one["lamps"], 1)
    ]
    yield from gauge("projector_lamp_hours", "hours of a lamp", lamps)
    errors: list[Sample] = [
        ({"projector": one["name"], "part": error["part"], "severity": error["severity"]}, 1)
        for one in projectors
        for error in one["errors"]
    ]
    yield from gauge("projector_error", "a warning or an error of a projector's part", errors)


def _escaped(text: str) -> str:
    """Escape the value of a label, as the text format wants."""
    return text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
