"""``python -m e2e.delay``: what `e2e.measure.command` offers, and a page of all that was found."""

from __future__ import annotations

import sys
import time

from e2e.delay import report
from e2e.delay.suite import SUITE
from e2e.measure.command import OUT, main

if __name__ == "__main__":
    began_s = time.time()
    status = main(SUITE)
    results = OUT / SUITE.name / "results.jsonl"
    if results.exists() and results.stat().st_mtime >= began_s:
        report.write(results.parent)
    sys.exit(status)
