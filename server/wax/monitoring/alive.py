"""``python -m wax.monitoring.alive CONFIG``: a container's health check.

It runs every few seconds, so it imports nothing of the server, and reads only the port from the
configuration.
"""

from __future__ import annotations

import ssl
import sys
import tomllib
import urllib.request
from pathlib import Path
from typing import Final

PORT: Final = 8080
"""The default port."""
_LIMIT_S: Final = 2.0


def main(config: str) -> int:
    """Return 0 if the server answers by HTTP or HTTPS, else 1."""
    with Path(config).open("rb") as file:
        port = tomllib.load(file).get("server", {}).get("port", PORT)
    # The certificate is for the server's name, not for this address.
    unchecked = ssl.create_default_context()
    unchecked.check_hostname, unchecked.verify_mode = False, ssl.CERT_NONE
    handlers = urllib.request.HTTPSHandler(context=unchecked), urllib.request.ProxyHandler({})
    opener = urllib.request.build_opener(*handlers)
    for scheme in ("http", "https"):
        try:
            with opener.open(f"{scheme}://127.0.0.1:{port}/healthz", timeout=_LIMIT_S):
                return 0
        except OSError as error:
            why = error
    print(why, file=sys.stderr)  # noqa: T201  # it goes to the container's log
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
