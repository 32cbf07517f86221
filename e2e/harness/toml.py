"""Configurations that several tests start a server with, and TOML from a tree."""

from __future__ import annotations

import json
import tomllib
from typing import TYPE_CHECKING, Any

from wax.config.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Mapping

MANY_PLAYED_BY_ONE: dict[str, Any] = {
    "server": {
        "max_share_per_address": 1.0,
        "max_offers_per_address_hz": 100.0,
        "max_silent_per_address": 100,
        "max_connections_per_address": 640,
    },
    "turns": {"max_waiting_per_address": 1000},
}
"""In a test one machine plays many people: no limit of one address holds, unless a test sets it."""


def as_shipped() -> dict[str, Any]:
    """Return the limits of one address with their defaults, for what measures these."""
    shipped = Settings().model_dump()
    return {
        name: {key: shipped[name][key] for key in keys} for name, keys in MANY_PLAYED_BY_ONE.items()
    }


CARD = """
[video]
source = "testcard"
[audio]
source = "testcard"
"""
"""Picture and sound that can be read back; everything else as shipped."""

BRIEF_GRACE = "grace_s = 0.5"
"""A viewer who closes their page is forgotten soon, so the next test need not wait their turn."""


def card(codec: str) -> str:
    """Encode the test card with one of the two video codecs."""
    return CARD.replace("[audio]", f'codec = "{codec}"\n[audio]')


def card_with(**sections: str) -> str:
    """Add tables to the test card, as ``turns="turn_s = 3.0"``; ``__`` in a name is a dot."""
    tables = [f"[{name.replace('__', '.')}]\n{keys}\n" for name, keys in sections.items()]
    return CARD + "\n".join(tables)


def for_one_machine(text: str) -> str:
    """Add `MANY_PLAYED_BY_ONE` to a configuration; what cannot be read stays as it is."""
    try:
        return dumps(merged(MANY_PLAYED_BY_ONE, tomllib.loads(text)))
    except tomllib.TOMLDecodeError:
        return text


def merged(*trees: Mapping[str, Any]) -> dict[str, Any]:
    """Merge tables key by key; later ones win, and lists are replaced."""
    result: dict[str, Any] = {}
    for tree in trees:
        for key, value in tree.items():
            before = result.get(key)
            both = isinstance(before, dict) and isinstance(value, dict)
            result[key] = merged(before or {}, value) if both else value
    return result


def dumps(tree: Mapping[str, Any]) -> str:
    """Write what `tomllib` would read back: tables of numbers, texts, truth values and lists.

    Raises `TypeError` for anything else; TOML has no null.
    """
    return "".join(_table(tree, ()))


def _table(tree: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    """Return a table's own keys first: after another's header they would belong to that one."""
    tables = {name: value for name, value in tree.items() if isinstance(value, dict)}
    lines = [f"[{'.'.join(map(_text, path))}]\n"] if path else []
    lines += [
        f"{_text(name)} = {_value(value)}\n" for name, value in tree.items() if name not in tables
    ]
    for name, table in tables.items():
        lines += _table(table, (*path, name))
    return lines


def _value(value: Any) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case int() | float():
            return repr(value)
        case str():
            return _text(value)
        case list():
            return f"[{', '.join(map(_value, value))}]"
        case dict():
            keys = (f"{_text(name)} = {_value(one)}" for name, one in value.items())
            return f"{{{', '.join(keys)}}}"
    raise TypeError(f"TOML cannot say {value!r}")


def _text(text: str) -> str:
    # JSON's escapes are TOML's, except for one character that TOML forbids unescaped.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
