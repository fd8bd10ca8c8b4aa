"""Plots are written all or none, and never over a file of another kind."""

import pytest
from PIL import Image

from subsea.base import report_files as plot_files
from subsea.base.errors import UserError
from subsea.base.report_files import check_plots, write_plots


def page(figure):
    figure.set_size_inches(4, 3)
    figure.subplots().plot([0, 1], [0, 1])


def test_each_name_gets_a_page(tmp_path):
    names = ["a.png", "b.png"]
    written = write_plots(tmp_path / "plots", dict.fromkeys(names, page))
    assert [path.name for path in written] == names
    for path in written:
        with Image.open(path) as picture:
            assert picture.size == (4 * plot_files.DPI, 3 * plot_files.DPI)


def test_an_interrupt_leaves_no_page(tmp_path):
    calls = []

    def check():
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_plots(tmp_path, {"a.png": page, "b.png": page}, check)
    assert not [*tmp_path.iterdir()]


def test_a_style_is_that_of_the_page_alone(tmp_path):
    import matplotlib

    sizes = []
    before = matplotlib.rcParams["font.size"]
    draw = {"a.png": lambda figure: sizes.append(matplotlib.rcParams["font.size"])}
    write_plots(tmp_path, draw)
    write_plots(tmp_path, draw, style={"font.size": 17})
    assert sizes == [plot_files.STYLE["font.size"], 17]
    assert matplotlib.rcParams["font.size"] == before


def test_what_is_in_the_way_is_named_before_any_work(tmp_path, monkeypatch):
    (tmp_path / "a.png").write_text("mine")
    check_plots(tmp_path, ["b.png"], force=False)
    check_plots(tmp_path, ["a.png"], force=True)
    with pytest.raises(UserError, match=r"a\.png"):
        check_plots(tmp_path, ["a.png"], force=False)
    with pytest.raises(UserError, match=r"a\.png"):
        check_plots(tmp_path / "a.png", ["b.png"], force=False)
    monkeypatch.setattr("subsea.base.system.find_spec", lambda name: None)
    with pytest.raises(UserError, match="plots need matplotlib"):
        check_plots(tmp_path, ["b.png"], force=False)
