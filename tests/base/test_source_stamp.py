"""Hashes of source files with all that they import."""

from subsea.base.source_stamp import package_stamps, source_stamp


def written(root, values):
    files = {
        "subsea/a/one.py": "from subsea.b.two import x\n",
        "subsea/b/two.py": "from subsea import __version__\nx = 1\n",
        "subsea/b/unused.py": "y = 1\n",
        "subsea/__init__.py": "__version__ = 1\n",
    }
    for name, text in (files | values).items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root / "subsea/a/one.py"


def test_stamps_by_package_say_where_code_differs(tmp_path):
    before = package_stamps(written(tmp_path / "1", {}), tmp_path / "1")
    assert list(before) == ["subsea", "subsea/a", "subsea/b"]
    for change, packages in (
        ({}, set()),
        ({"subsea/b/unused.py": "y = 2\n"}, set()),
        ({"subsea/b/two.py": "from subsea import __version__\nx = 2\n"}, {"subsea/b"}),
        ({"subsea/__init__.py": "__version__ = 2\n"}, {"subsea"}),
    ):
        root = tmp_path / f"2 {change}".replace("/", "-")[:40]
        file = written(root, change)
        after = package_stamps(file, root)
        assert {name for name in before if before[name] != after[name]} == packages
        same = source_stamp(file, root) == source_stamp(
            tmp_path / "1/subsea/a/one.py", tmp_path / "1"
        )
        assert same == (not packages)
