"""Adds what a door's line says to a configuration, however that is written. Pure."""

from __future__ import annotations

import re
import tomllib
from typing import TYPE_CHECKING, Any, Final

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

from wax.config.as_toml import as_toml
from wax.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from wax.door.line import DoorLine

_TABLE: Final = r"(?m)^\[{name}\][ \t]*(?:#.*)?$\n?"
_TURN: Final = ("turn:{}:3478", "turn:{}:3478?transport=tcp", "turns:{}:5349?transport=tcp")


def files(line: DoorLine, path: Path) -> dict[Path, str]:
    """Return the secrets' files, beside the configuration at `path`, with their content."""
    key = Ed25519PrivateKey.from_private_bytes(line.seed)
    pem = key.private_bytes(Encoding.PEM, PrivateFormat.OpenSSH, NoEncryption()).decode()
    key_file, secret_file = _places(path)
    return {key_file: pem, secret_file: f"{line.relay_secret}\n"}


def with_door(text: str, line: DoorLine, path: Path) -> str:
    """Return the configuration with the door; comments and all other keys stay.

    Raises `ConfigError` if a key is written in a form that this cannot edit.
    """
    key_file, secret_file = map(str, _places(path))
    tables: dict[str, dict[str, Any]] = {
        "server": {
            "public_url": f"https://{line.name}",
            "trusted_proxies": ["127.0.0.1", "::1"],
            "https": False,
        },
        "network": {"mode": "full-ice", "stun": [f"stun:{line.host}:3478"]},
        "relay": {
            "urls": [one.format(line.host) for one in _TURN],
            "secret_file": secret_file,
            "secret": "",
        },
        "door": {
            "host": line.host,
            "port": line.port,
            "host_key": line.host_key,
            "key_file": key_file,
        },
    }
    before = tomllib.loads(text)
    after = dict(before)
    for name, keys in tables.items():
        # What is off by default is written only to switch it off.
        told = {key: one for key, one in keys.items() if one or key in before.get(name, {})}
        text = _with_table(text, name, told)
        after[name] = before.get(name, {}) | told
    try:
        is_right = tomllib.loads(text) == after
    except tomllib.TOMLDecodeError:
        is_right = False
    if not is_right:
        by_hand = "\n".join(f"[{name}]\n{_lines(keys)}" for name, keys in tables.items())
        raise ConfigError(
            f"{path} is written in another way than expected; add by hand:\n{by_hand}"
        )
    return text


def _with_table(text: str, name: str, keys: Mapping[str, Any]) -> str:
    header = re.search(_TABLE.format(name=name), text)
    if header is None:
        return f"{text.rstrip()}\n\n[{name}]\n{_lines(keys)}"
    head, body = text[: header.end()], text[header.end() :]
    end = re.search(r"(?m)^\[", body)
    own, rest = (body, "") if end is None else (body[: end.start()], body[end.start() :])
    for key in keys:
        own = re.sub(rf"(?m)^{key}[ \t]*=.*$\n?", "", own)
    return f"{head.rstrip()}\n{_lines(keys)}{own}{rest}"


def _lines(keys: Mapping[str, Any]) -> str:
    return "".join(f"{key} = {as_toml(value)}\n" for key, value in keys.items())


def _places(path: Path) -> tuple[Path, Path]:
    """Return the paths of the private key and the relay's secret."""
    place = path.absolute()
    return place.with_suffix(".door-key"), place.with_suffix(".turn-secret")
