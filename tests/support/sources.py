"""Python sources as trees of syntax."""

import ast
import gc
from pathlib import Path


def parsed(path: Path) -> ast.Module:
    """Parse a file while no garbage is collected.

    A collected task of asyncio logs its exception, whose traceback parses lines of source: Python
    3.11 fails with a SystemError when one parse begins within another.
    """
    gc.disable()
    try:
        return ast.parse(path.read_text(encoding="utf-8"))
    finally:
        gc.enable()
