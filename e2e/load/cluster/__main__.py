"""``python -m e2e.load.cluster``: observers past one machine."""

from __future__ import annotations

import sys

from e2e.load.cluster.suite import SUITE
from e2e.measure.command import main

if __name__ == "__main__":
    sys.exit(main(SUITE))
