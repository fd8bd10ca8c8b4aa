"""Build a wheel that carries compiled kernels: `make wheel`.

.venv/bin/python tools/build_wheel.py [FOLDER]

Compiles the kernels of a dive for a common processor, and packs them with the package into
FOLDER (dist). The wheel fits this version of Python and this system. Without this tool a build
makes a pure wheel, whose first start compiles.
"""

import platform
import shutil
import sys
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

    from subsea.kernels.cache import Target, processor, write_manifest

    for source in {path.parent for path in (ROOT / "subsea").rglob("*.py")}:
        cached = compiled / _CacheLocator.get_suitable_cache_subpath(str(source / "any.py"))
        if cached.is_dir():
            shutil.copytree(cached, folder / source.relative_to(ROOT), dirs_exist_ok=True)
    write_manifest(folder, Target(processor().triple, *TARGETS[platform.machine()]))
