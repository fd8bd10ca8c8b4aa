"""Python source as a tree of syntax."""

import ast
import gc


def parse_source(text: str) -> ast.Module:
    """Parse Python source while no garbage is collected.

    A task of asyncio logs its exception when it is collected, and the traceback parses source.
    Python 3.11 fails with a SystemError when one parse begins within another.
    """
    collects = gc.isenabled()
    gc.disable()
    try:
        return ast.parse(text)
    finally:
        if collects:
            gc.enable()
