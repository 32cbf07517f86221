"""``python -m e2e.faults``: what `e2e.measure.command` offers, for the faults."""

from __future__ import annotations

import sys

from e2e.faults.suite import SUITE
from e2e.measure.command import main

if __name__ == "__main__":
    sys.exit(main(SUITE))
