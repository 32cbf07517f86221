"""``python -m e2e.stop``: what `e2e.measure.command` offers, for the faults."""

from __future__ import annotations

import sys

from e2e.measure.command import main
from e2e.stop.suite import SUITE

if __name__ == "__main__":
    sys.exit(main(SUITE))
