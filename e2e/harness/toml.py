"""Server configurations that several tests share."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

import tomlkit

from wax.config.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

MANY_PLAYED_BY_ONE: dict[str, Any] = {
    "server": {
        "max_share_per_address": 1.0,
        "max_offers_per_address_hz": 100.0,
        "max_silent_per_address": 100,
        "max_connections_per_address": 640,
    },
    "turns": {"max_waiting_per_address": 1000},
}
"""One machine plays many people, so no limit for each address applies, unless a test sets it."""


PICTURE: dict[str, Any] = {"video": {"width": 640, "height": 480}}
"""What every server of a test sends unless its configuration says otherwise: what the tests assume,
and several browsers on a small machine decode."""


def as_shipped() -> dict[str, Any]:
    """Return the limits for each address with their defaults, for what measures these."""
    shipped = Settings().model_dump()
    return {
        name: {key: shipped[name][key] for key in keys} for name, keys in MANY_PLAYED_BY_ONE.items()
    }


MEDIA: dict[str, Any] = {"video": {"source": "testcard"}, "audio": {"source": "testcard"}}
CARD = tomlkit.dumps(MEDIA)
"""Picture and sound that can be read back; everything else as shipped."""


def card_with(**sections: str) -> str:
    """Add tables to the test card's, as ``turns="turn_s = 3.0"``; ``__`` in a name is a dot."""
    tables = [f"[{name.replace('__', '.')}]\n{keys}\n" for name, keys in sections.items()]
    return CARD + "\n".join(tables)


def card_on(port: Path) -> str:
    """Configure the test card, with a robot on this serial port."""
    serial = f'url = "{port}"\ndialect = "frames"\nreopen_s = 0.2'
    return card_with(robot='driver = "serial"', robot__serial=serial)


def for_one_machine(text: str) -> str:
    """Add `MANY_PLAYED_BY_ONE` and `PICTURE` to a configuration."""
    return tomlkit.dumps(merged(MANY_PLAYED_BY_ONE, PICTURE, tomllib.loads(text)))


def merged(*trees: Mapping[str, Any]) -> dict[str, Any]:
    """Merge tables key by key, without changing any; later ones win, and lists are replaced."""
    result: dict[str, Any] = {}
    for tree in trees:
        for key, value in tree.items():
            before = result.get(key)
            below = before if isinstance(before, dict) else {}
            result[key] = merged(below, value) if isinstance(value, dict) else value
    return result


FEW_PICTURES = tomlkit.dumps(merged(MEDIA, {"video": {"fps": 10.0}}))
"""For judging the sound: drawing pictures leaves a small machine no time for it."""
