"""``python -m e2e.load``: the command line of `e2e.measure.command`, for the benchmarks."""

from __future__ import annotations

import sys

from e2e.load.suite import SUITE
from e2e.measure.command import main

if __name__ == "__main__":
    sys.exit(main(SUITE))
