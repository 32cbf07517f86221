"""The docstrings below the fields of a class, which Python itself does not keep."""

from __future__ import annotations

import ast
import inspect
import textwrap
from functools import cache
from itertools import pairwise


def field_docs(model: type) -> dict[str, str]:
    """Return what stands below each field of a class, or of one of its bases."""
    found: dict[str, str] = {}
    for base in reversed(model.__mro__):
        found |= _own(base)
    return found


@cache
def _own(model: type) -> dict[str, str]:
    try:
        (definition,) = ast.parse(textwrap.dedent(inspect.getsource(model))).body
    except (OSError, TypeError, SyntaxError):  # Python's own, or a plug-in without plain source
        return {}
    found = {}
    for field, below in pairwise(getattr(definition, "body", [])):
        match field, below:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(ast.Constant(value=str(text))):
                found[name] = inspect.cleandoc(text).rstrip()
    return found
