"""Tables of sweeps."""

import pyarrow
from pyarrow import parquet

from subsea.lab.sweep import columns_of, write_csv, write_parquet

LINES = [
    {"run": "a", "seed": 1, "n": "3", "x": "1", "on": "true", "ticks": 9, "sea.share": 0.5},
    {"run": "b", "seed": 2, "n": "4", "x": "2.5", "on": "false", "ticks": 9, "more": 1.0},
]


def test_values_become_numbers_if_all_of_a_column_are():
    columns = columns_of(LINES)
    assert columns["n"] == [3, 4]
    assert columns["x"] == [1.0, 2.5]
    assert columns["on"] == [True, False]
    assert columns["more"] == [None, 1.0]
    words = [{"p": "[1, 2]", "k": "1"}, {"p": "[3, 4]", "k": "true"}]
    assert columns_of(words) == {"p": ["[1, 2]", "[3, 4]"], "k": ["1", "true"]}


def test_both_files_have_the_columns(tmp_path):
    for write in (write_csv, write_parquet):
        write(tmp_path / write.__name__, LINES)
    text = (tmp_path / "write_csv").read_text()
    assert text == (
        "run,seed,n,x,on,ticks,sea.share,more\na,1,3,1.0,True,9,0.5,\nb,2,4,2.5,False,9,,1.0\n"
    )
    table = parquet.read_table(tmp_path / "write_parquet")
    assert table.to_pydict() == columns_of(LINES)
    types = {name: str(table.schema.field(name).type) for name in table.column_names}
    assert types == {
        "run": "string", "seed": "int64", "n": "int64", "x": "double", "on": "bool",
        "ticks": "int64", "sea.share": "double", "more": "double",
    }  # fmt: skip


def test_no_run_is_an_empty_table(tmp_path):
    write_csv(tmp_path / "a.csv", [])
    write_parquet(tmp_path / "a.parquet", [])
    assert parquet.read_table(tmp_path / "a.parquet").num_rows == 0
    assert pyarrow.__version__
