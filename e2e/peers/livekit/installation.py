"""Where LiveKit's server and its browser library are on this machine."""

from __future__ import annotations

import importlib.util
import json
import os
from pathlib import Path
from typing import Final

from e2e.peers.livekit.errors import LiveKitError

VERSION: Final = "1.11.0"
"""Of the server, as .make/livekit.sh builds it."""

_ROOT: Final = Path(__file__).parents[3]
_BUILT: Final = _ROOT / ".cache/livekit/server"
_SDK: Final = "livekit"
_PACKAGE: Final = _ROOT / "web/node_modules/livekit-client"


def find_server() -> Path:
    """Path of the server: ``WAX_LIVEKIT``, else what make has built.

    Raises `LiveKitError` when there is none.
    """
    named = os.environ.get("WAX_LIVEKIT")
    path = Path(named) if named else _BUILT
    if os.access(path, os.X_OK) and path.is_file():
        return path
    if named:
        raise LiveKitError(
            f"WAX_LIVEKIT names no program: {named}; set it to livekit-server's path"
        )
    raise LiveKitError(
        f"LiveKit {VERSION} is not built; install Go and type sh .make/livekit.sh, "
        "or set WAX_LIVEKIT to the path of livekit-server"
    )


def find_client() -> Path:
    """Path of livekit-client as one script for browsers. Raises `LiveKitError`."""
    path = _PACKAGE / "dist/livekit-client.umd.js"
    if not path.is_file():
        raise LiveKitError(
            "livekit-client is not installed; type make check, which installs the page's packages"
        )
    return path


def check_sdk() -> None:
    """Raise `LiveKitError` where its Python SDK is missing."""
    if importlib.util.find_spec(_SDK) is None:
        raise LiveKitError("the package livekit is not installed; type make check")


def client_version() -> str:
    return str(json.loads((_PACKAGE / "package.json").read_text(encoding="utf-8"))["version"])
