"""Functions of a program: their names, a hash of their code, and what they raised."""

import inspect
import pickle
import textwrap
from collections.abc import Iterable
from functools import partial
from hashlib import sha256
from pathlib import Path
from traceback import extract_tb
from typing import Any

from subsea.base.errors import printable

MOST_TOLD = 200  # characters of another program's error
HERE = str(Path(__file__).parent)


def described(function: Any) -> str:
    """Describe a function by what it says of itself, or by its place in the code."""
    return getattr(function, "description", None) or place_of(function)


def identified(function: Any) -> str:
    """Name the module and the function, with a hash of its text and of its bound values."""
    return f"{place_of(function)} sha256 {digest_of(function)[:16]}"


def place_of(function: Any) -> str:
    """Name the module and the function, or the function that a `partial` calls."""
    inner = _inner(function)
    module = getattr(inner, "__module__", type(inner).__module__)
    return f"{module}.{getattr(inner, '__qualname__', type(inner).__qualname__)}"


def name_of(function: Any) -> str:
    """Name the function without its module."""
    return getattr(_inner(function), "__name__", type(function).__name__)


def digest_of(function: Any) -> str:
    """Hash the text of a function, or its code, and the values that are bound to it.

    Values are those of a `partial` and of enclosing functions. What the function calls does not
    count.
    """
    inner = _inner(function)
    plain = getattr(inner, "py_func", inner)
    try:
        text = textwrap.dedent(inspect.getsource(plain)).encode()
    except (OSError, TypeError):
        code = getattr(plain, "__code__", None)
        text = pickle.dumps(plain) if code is None else code.co_code + repr(code.co_consts).encode()
    cells = [one.cell_contents for one in getattr(plain, "__closure__", None) or ()]
    bound: list[Any] = [*cells, getattr(plain, "__defaults__", None)]
    while isinstance(function, partial):
        bound += [*function.args, *sorted(function.keywords.items())]
        function = function.func
    sha = sha256(text)
    for value in bound:
        try:
            sha.update(pickle.dumps(value))
        except (pickle.PicklingError, AttributeError, TypeError):
            sha.update(place_of(value).encode())
    return sha.hexdigest()


def parameters_of(function: Any, known: Iterable[str] = ()) -> list[str]:
    """List the parameters to fill, in order; those with a default value only if they are `known`.

    Raises TypeError or ValueError if they cannot be found out.
    """
    return [
        one.name
        for one in inspect.signature(function).parameters.values()
        if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)
        and (one.default is one.empty or one.name in known)
    ]


def stays(value: Any) -> bool:
    """True if no other process can import it: of a notebook, a script or another function."""
    try:
        return b"__main__" in pickle.dumps(value)
    except (pickle.PicklingError, AttributeError, TypeError):
        return True


def raised(fault: Exception) -> str:
    """Give the kind, the first lines and the place of another program's error, as one line."""
    lines = [line.strip() for line in str(fault).splitlines() if line.strip()]
    text = printable(" ".join(lines[:2]))[:MOST_TOLD]
    return f"raised {type(fault).__name__}: {text}{_line_of(fault)}"


def short(value: Any) -> str:
    """Write a value in at most 60 characters."""
    return printable(" ".join(str(value).split()))[:60]


def _inner(function: Any) -> Any:
    while isinstance(function, partial):
        function = function.func
    return function


def _line_of(fault: BaseException) -> str:
    """Say where in a program an exception was raised: its last line outside of this package."""
    own = [
        place
        for place in extract_tb(fault.__traceback__)
        if not place.filename.startswith(HERE) and "site-packages" not in place.filename
    ]
    return f" (line {own[-1].lineno} of {own[-1].name})" if own else ""
