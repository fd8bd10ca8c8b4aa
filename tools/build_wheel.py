"""Build a wheel that carries compiled kernels and first results: `make wheel`.

.venv/bin/python tools/build_wheel.py [-d FOLDER]

Compiles the kernels of a dive for a common processor, computes what a first start of each shipped
scenario computes, and packs both with the package into FOLDER (dist). The wheel fits this version
of Python, numpy and numba, and this system. Without this tool a build makes a pure wheel, whose
first start compiles.
"""

import lzma
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

# Processors that shipped code is compiled for, and the features that it needs. Those of a Mac are
# the least that any Mac with that architecture has; its features are not told apart by numba.
X86_64_V3 = (
    "x86-64-v3",
    "+64bit,+avx,+avx2,+bmi,+bmi2,+cmov,+crc32,+cx16,+cx8,+f16c,+fma,+fxsr,+lzcnt,+mmx,+movbe,"
    "+popcnt,+sahf,+sse,+sse2,+sse3,+sse4.1,+sse4.2,+ssse3,+xsave",
)
TARGETS = {"x86_64": X86_64_V3, "AMD64": X86_64_V3, "arm64": ("apple-m1", "")}
# Skins, which are painted as quickly, and checked repertoires, which the package has already.
NOT_SHIPPED = "paint-", "read-"


def target_settings() -> dict[str, str]:
    """Settings of numba for the processes that compile for the wheel."""
    cpu, features = TARGETS[platform.machine()]
    return {
        "NUMBA_CPU_NAME": cpu, "NUMBA_CPU_FEATURES": features,
        "NUMBA_DISABLE_INTEL_SVML": "1",  # a library that users may lack
    }  # fmt: skip


def collect_kernels(compiled: Path, folder: Path) -> None:
    """Copy the code in a cache of numba to a folder, by the folders of its sources."""
    from numba.core.caching import _CacheLocator

    from subsea.dive.warm_up import code_stamp
    from subsea.kernels.cache import Target, processor, write_manifest

    for source in {path.parent for path in (ROOT / "subsea").rglob("*.py")}:
        cached = compiled / _CacheLocator.get_suitable_cache_subpath(str(source / "any.py"))
        if cached.is_dir():
            shutil.copytree(cached, folder / source.relative_to(ROOT), dirs_exist_ok=True)
    target = Target(processor().triple, *TARGETS[platform.machine()])
    write_manifest(folder, target, code_stamp())


def compile_kernels() -> None:
    """Compile the kernels of a dive into the cache of numba, in processes of their own."""
    from subsea.base.system import cores
    from subsea.dive.warm_up import compile_all

    if not compile_all(cores(), lambda line: print(line, flush=True)):
        sys.exit("a kernel does not compile; run the jobs of subsea/dive/warm_up.py to see why")


def keep_results(folder: Path) -> None:
    """Keep what the first picture of each shipped scenario needs in a folder."""
    from subsea.base import disk_cache
    from subsea.base.system import resource_names
    from subsea.cli.main import main as subsea

    kept = folder.parents[1] / "kept"
    disk_cache.cache_folder = lambda: kept
    folder.mkdir()
    for name in resource_names("assets/scenarios", ".toml"):
        start = ["--scenario", name, "--seconds", "0.05"]
        picture, record = (str(folder.parents[1] / f"{name}{end}") for end in (".png", ".h5"))
        film, simulate = ["film", picture, "--size", "64x64"], ["simulate", "--out", record]
        if subsea(film + start) and subsea(simulate + start):  # without OpenGL the world alone
            sys.exit(f"{name} does not start")
    for path in kept.iterdir():
        if not path.name.startswith(NOT_SHIPPED):
            shipped = (folder / path.name).with_suffix(".xz")
            shipped.write_bytes(lzma.compress(path.read_bytes()))


def main() -> None:
    """Build the wheel."""
    if platform.machine() not in TARGETS:
        sys.exit(f"no processor is chosen for {platform.machine()}; see TARGETS in {__file__}")
    with tempfile.TemporaryDirectory() as folder:
        made, data = Path(folder), Path(folder) / "_data"
        # Before numba is imported. A cache of its own: a result that is kept already would leave
        # the kernels that make it uncompiled.
        os.environ |= target_settings() | {
            "NUMBA_CACHE_DIR": str(made / "compiled"), "XDG_CACHE_HOME": str(made / "cache"),
        }  # fmt: skip
        compile_kernels()
        data.mkdir()
        keep_results(data / "kept")
        collect_kernels(made / "compiled", data / "kernels")
        build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel"]
        os.environ["SUBSEA_SHIPPED"] = str(data)
        sys.exit(subprocess.run([*build, *sys.argv[1:]], cwd=ROOT, check=False).returncode)


if __name__ == "__main__":
    main()
