"""``python -m e2e.delay.voice``: what `e2e.measure.command` offers, for the voice to the robot."""

from __future__ import annotations

import sys

from e2e.delay.voice.suite import SUITE
from e2e.measure.command import main

if __name__ == "__main__":
    sys.exit(main(SUITE))
