"""Prints the manual, `config/wax.toml`: `make manual`."""

from __future__ import annotations

import sys

from wax.config import manual
from wax.config.settings import Settings

if __name__ == "__main__":
    sys.stdout.write(manual.whole(Settings))
