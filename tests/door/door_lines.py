"""The line that a door prints, for tests."""

from __future__ import annotations

import base64
import hashlib

HOST_KEY, SEED = bytes(range(32)), bytes(range(32, 64))


def door_line(
    *,
    name: str = "robot.example.org",
    page: str = "",
    port: str = "20001",
    secret: str = 8 * "c0ffee42",
) -> str:
    host, seed = (base64.b64encode(key).decode() for key in (HOST_KEY, SEED))
    body = f"wax-door-1:{name}:{page or name}:{port}:{host}:{seed}:{secret}"
    return f"{body}:{hashlib.sha256(body.encode()).hexdigest()[:8]}"
