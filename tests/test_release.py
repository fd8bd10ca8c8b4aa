"""The package that is published: what it holds, and a picture from it outside of the checkout."""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
from email import message_from_bytes
from pathlib import Path
from zipfile import ZipFile

import pytest
import yaml

import subsea
from tools.package_readme import PackageReadme

ROOT = Path(__file__).parents[1]
REPOSITORY = "https://example.org/somebody/subsea"


@pytest.fixture(scope="module")
def dist(tmp_path_factory):
    """A folder with the source distribution, unpacked, and the wheel that is built from it."""
    folder = tmp_path_factory.mktemp("dist")
    env = os.environ | {"SUBSEA_REPOSITORY": REPOSITORY}

    def build(kind, source):
        command = [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(folder)]
        subprocess.run(command, cwd=source, env=env, check=True, capture_output=True)
        [made] = folder.glob("*.tar.gz" if kind == "sdist" else "*.whl")
        return made

    sources = build("sdist", ROOT)
    with tarfile.open(sources) as archive:
        safe = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}  # from Python 3.11.4
        archive.extractall(folder, **safe)
    build("wheel", folder / sources.name.removesuffix(".tar.gz"))
    return folder


@pytest.fixture(scope="module")
def wheel(dist):
    """The wheel."""
    [path] = dist.glob("*.whl")
    return path


def test_a_build_from_the_source_distribution_finds_the_readme(dist, monkeypatch):
    """Without an address of the repository, the build reads the README again."""
    monkeypatch.delenv("SUBSEA_REPOSITORY", raising=False)
    metadata = {}
    PackageReadme(str(dist / f"subsea-{subsea.__version__}"), {}).update(metadata)
    text = metadata["readme"]["text"]
    assert "# subsea" in text
    assert "![" not in text and "](docs" not in text and "\n\n\n" not in text


def test_the_wheel_holds_all_modules_and_resources_and_nothing_compiled(wheel):
    held = set(ZipFile(wheel).namelist())
    wanted = {
        path.relative_to(ROOT).as_posix()
        for package in ("subsea", "capture")
        for path in (ROOT / package).rglob("*")
        if path.suffix in (".py", ".pyi", ".typed")
    } | {
        f"subsea/_data/{path.relative_to(ROOT).as_posix()}"
        for folder in ("assets", "shaders", "repertoires")
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and not path.name.startswith(".")
    }
    assert wanted <= held
    assert {Path(name).parts[0] for name in held - wanted} == {
        f"subsea-{subsea.__version__}.dist-info"
    }


def test_the_package_page_has_the_readme_with_links_that_work(wheel):
    page = message_from_bytes(
        ZipFile(wheel).read(f"subsea-{subsea.__version__}.dist-info/METADATA")
    )
    assert page["Version"] == subsea.__version__
    text = page.get_payload()
    targets = re.findall(r"\]\(([^)]+)\)", text)
    assert targets and all(re.match("https://|#", target) for target in targets)
    here = f"{REPOSITORY}/(raw|blob)/v{subsea.__version__}/"
    files = [re.sub(here, "", target) for target in targets if target.startswith(REPOSITORY)]
    assert files and all((ROOT / name.partition("#")[0]).exists() for name in files)


def test_an_installed_wheel_works_outside_of_the_checkout(wheel, tmp_path, pytestconfig):
    """It films there at night.

    With the compiled code of this checkout, which the same sources may use anywhere.
    """
    ZipFile(wheel).extractall(tmp_path / "lib")
    for path in (ROOT / "subsea").rglob("__pycache__/*"):
        if path.suffix in (".nbi", ".nbc") or path.name.startswith("warm-"):
            target = tmp_path / "lib" / path.relative_to(ROOT)
            target.parent.mkdir(exist_ok=True, parents=True)
            shutil.copy2(path, target)
    env = os.environ | {"PYTHONPATH": str(tmp_path / "lib")}

    def run(*words):
        done = subprocess.run(
            [sys.executable, "-P", *words], cwd=tmp_path, env=env, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    where = run("-c", "import subsea; print(subsea.__file__)")
    assert where.startswith(str(tmp_path))
    for program in ("subsea", "capture"):
        assert run("-m", program, "--version") == f"subsea {subsea.__version__}\n"
    if not pytestconfig.getoption("--nightly"):
        return
    run("-m", "subsea", "film", "sea.png", "--seconds", "0.05", "--size", "160x90")
    assert (tmp_path / "sea.png").read_bytes().startswith(b"\x89PNG")


def test_the_version_has_one_place():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert "version" in project["project"]["dynamic"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == subsea.__version__
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    [released] = re.findall(
        rf"^## \[{re.escape(subsea.__version__)}\] - (.+)$",
        (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE,
    )  # fmt: skip
    assert str(citation["date-released"]) == released


def test_publishing_begins_with_a_tag_and_reads_no_secret():
    text = (ROOT / ".github/workflows/publish.yml").read_text()
    workflow = yaml.safe_load(text)
    assert workflow[True] == {"push": {"tags": ["v*"]}}  # YAML reads the key `on` as True
    assert "secrets" not in text and "password" not in text
    assert workflow["jobs"]["publish"]["permissions"] == {"id-token": "write"}
