"""The configuration: any file's content becomes settings or a sentence about it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Final

from tests.fuzz.target import Target

from wax.config import settings
from wax.errors import ConfigError

_ROOT: Final = Path(__file__).parents[3]
_MANUAL: Final = (_ROOT / "config/wax.toml").read_bytes()


def _hear(data: bytes) -> None:
    handle, name = tempfile.mkstemp(suffix=".toml")
    path = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        found = settings.load(path)
    except ConfigError as error:
        if not str(error).startswith(name):
            raise AssertionError("a sentence that does not name the file") from error
    else:
        assert isinstance(found, settings.Settings)
    finally:
        path.unlink()


def _sections() -> tuple[bytes, ...]:
    """Return the manual's sections without comments: all keys, in pieces that mutate well."""
    lines = [line.split(b"  #")[0].rstrip() for line in _MANUAL.splitlines()]
    kept = b"\n".join(line for line in lines if line and not line.startswith(b"#"))
    return tuple(b"[" + part for part in kept.split(b"\n[") if part)


CONFIG: Final = Target(
    name="config",
    what="configuration files",
    hear=_hear,
    seeds=tuple(part.replace(b"[[[", b"[[") for part in _sections()),
    words=(
        b"[robot]\n", b"[robot.serial]\n", b"[[ice.servers]]\n", b"true", b"inf", b"nan", b'""',
        b"[]", b"{}", b'"\\u0000"', b"0x", b"1979-05-27T07:32:00Z", b"'''", b'"""', b"[" * 60,
        b"a." * 40, b"\xef\xbb\xbf",
    ),
    max_bytes=2048,
    steps=5_000_000,  # the host's own file, once: a wrong key is compared with all others
)  # fmt: skip
