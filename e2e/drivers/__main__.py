"""``python -m e2e.drivers``: what `e2e.measure.command` offers, for the drivers."""

from __future__ import annotations

import sys

from e2e.drivers.suite import SUITE
from e2e.measure.command import main

if __name__ == "__main__":
    sys.exit(main(SUITE))
