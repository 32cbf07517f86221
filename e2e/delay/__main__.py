"""``python -m e2e.delay``: what `e2e.measure.command` offers, and a page of all that was found."""

from __future__ import annotations

import sys

from e2e.delay import report
from e2e.delay.suite import SUITE
from e2e.measure.command import OUT, main

if __name__ == "__main__":
    folder = OUT / SUITE.name
    before = report.newest(folder)
    status = main(SUITE)
    if report.newest(folder) != before:
        report.write(folder)
    sys.exit(status)
