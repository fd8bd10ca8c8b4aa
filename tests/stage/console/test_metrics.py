"""Figures in the text format of Prometheus."""

from subsea.stage.console.metrics import metrics
from tests.stage.console.test_fleet_page import FLEET


def values(health):
    """The samples, without the lines about them."""
    lines = metrics(health, True, 0.5).splitlines()
    return dict(line.rsplit(" ", 1) for line in lines if not line.startswith("#"))


def test_figures_of_nodes_and_faults():
    health = {"fault": {"text": "a", "ago_s": 3.5}, "loading": True, "nodes": {"left": False}}
    lines = metrics(health, False, float("inf")).splitlines()
    assert [line for line in lines if not line.startswith("#")] == [
        "subsea_alive 0", "subsea_loading 1", "subsea_fault_age_seconds 3.5",
        'subsea_node_in_step{node="left"} 0',
    ]  # fmt: skip
    assert lines[0] == "# HELP subsea_alive 1 if a picture was drawn within ten seconds"
    assert lines[1] == "# TYPE subsea_alive gauge"


def test_figures_of_a_fleet():
    found = values({"fleet": FLEET})
    assert found['subsea_node_connected{node="left"}'] == "1"
    assert found['subsea_node_connected{node="right"}'] == "0"
    assert found['subsea_node_temperature_celsius{node="left"}'] == "63.5"
    assert found['subsea_node_free_disk_bytes{node="left"}'] == "120250000000.0"
    assert float(found['subsea_node_frame_seconds{node="left"}']) == 0.0167
    assert not [name for name in found if "temperature" in name and "right" in name]
    info = next(name for name in found if name.startswith("subsea_node_info") and "left" in name)
    assert 'renderer="GPU \\"X\\""' in info
    assert found['subsea_projector_lamp_hours{projector="left",lamp="1"}'] == "1234"
    error = 'subsea_projector_error{projector="left",part="fan",severity="warning"}'
    assert found[error] == "1"
    assert found['subsea_projector_answers{projector="right"}'] == "0"


def test_each_gauge_is_named_once():
    lines = metrics({"fleet": FLEET}, True, 0.5).splitlines()
    types = [line for line in lines if line.startswith("# TYPE")]
    assert len(types) == len(set(types))
    for line in lines:
        name = line.split("{")[0].split(" ")[0]
        assert line.startswith("#") or f"# TYPE {name} gauge" in types
