"""``python -m e2e.strangers.soak``: the command line of `e2e.measure.command`, for the soak."""

from __future__ import annotations

import sys

from e2e.measure.command import main
from e2e.strangers.soak.suite import SUITE

if __name__ == "__main__":
    sys.exit(main(SUITE))
