"""``python -m e2e.stop.drivers``: what `e2e.measure.command` offers, for the drivers."""

from __future__ import annotations

import sys

from e2e.measure.command import main
from e2e.stop.drivers.suite import SUITE

if __name__ == "__main__":
    sys.exit(main(SUITE))
