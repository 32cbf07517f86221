"""``python -m e2e.strangers``: what `e2e.measure.command` offers, for this suite."""

from __future__ import annotations

import sys

from e2e.measure.command import main
from e2e.strangers.suite import SUITE

if __name__ == "__main__":
    sys.exit(main(SUITE))
