"""``python -m e2e.load.page``: what `e2e.measure.command` offers, for the page."""

from __future__ import annotations

import sys

from e2e.load.page.suite import SUITE
from e2e.measure.command import main

if __name__ == "__main__":
    sys.exit(main(SUITE))
