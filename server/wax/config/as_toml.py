"""Writes values as TOML."""

from __future__ import annotations

import json
import re
from typing import Final

_SHORT: Final = 60
"""A list of tables that is longer than this has a line for each."""


def as_toml(value: object) -> str:
    """Return a value as TOML has it; raises `TypeError` for one that TOML lacks."""
    match value:
        case dict():
            inner = ", ".join(f"{key_as_toml(key)} = {as_toml(one)}" for key, one in value.items())
            return f"{{ {inner} }}" if inner else "{}"
        case list():
            items = [as_toml(one) for one in value]
            line = f"[{', '.join(items)}]"
            is_short = len(line) <= _SHORT or not isinstance(value[0], dict)
            return line if is_short else "".join(["[\n", *(f"    {one},\n" for one in items), "]"])
        case bool():
            return str(value).lower()
        case str():
            # TOML has JSON's escapes, except for one character that TOML does not allow unescaped.
            return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
        case int() if value >= 10_000 and value % 100 == 0:
            return f"{value:_}"
        case int() | float():
            return repr(value)
    raise TypeError(f"TOML cannot express {value!r}")


def key_as_toml(key: str) -> str:
    """Return a key, in quotes where it must have some."""
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else as_toml(key)
