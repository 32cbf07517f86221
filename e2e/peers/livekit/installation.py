"""Where LiveKit's server and its browser library are on this machine."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from e2e.measure.errors import NotRunError

VERSION: Final = "1.11.0"
"""The server's version, as .make/livekit.sh builds it."""

_ROOT: Final = Path(__file__).parents[3]
_BUILT: Final = _ROOT / ".cache/livekit/server"
_PACKAGE: Final = _ROOT / "web/node_modules/livekit-client"


def find_server() -> Path:
    """Return the server's path: ``WAX_LIVEKIT``, or the one that make has built.

    Raises `NotRunError` if there is none.
    """
    named = os.environ.get("WAX_LIVEKIT")
    path = Path(named) if named else _BUILT
    if os.access(path, os.X_OK) and path.is_file():
        return path
    if named:
        raise NotRunError(f"WAX_LIVEKIT names no program: {named}; set it to livekit-server's path")
    raise NotRunError(
        f"LiveKit {VERSION} is not built; install Go and type sh .make/livekit.sh, "
        "or set WAX_LIVEKIT to the path of livekit-server"
    )


def find_client() -> Path:
    """Return the path of livekit-client as one script for browsers. Raises `NotRunError`."""
    path = _PACKAGE / "dist/livekit-client.umd.js"
    if not path.is_file():
        raise NotRunError(
            "livekit-client is not installed; type make check, which installs the page's packages"
        )
    return path
