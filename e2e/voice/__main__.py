"""``python -m e2e.voice``: what `e2e.measure.command` offers, for the voice to the robot."""

from __future__ import annotations

import sys

from e2e.measure.command import main
from e2e.voice.suite import SUITE

if __name__ == "__main__":
    sys.exit(main(SUITE))
