"""`wax` on paper: all of it is real, but each stop takes as long as the configuration lets it.

Started as ``python -m tests.session.paper_proof``, with the arguments of `wax`.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import pytest

from wax.__main__ import main
from wax.commands.proof import command
from wax.commands.proof.measure import Sample
from wax.commands.proof.proof import Proof

if TYPE_CHECKING:
    from wax.client.process import Order
    from wax.commands.proof.verdict import Fault, Findings


class PaperProof(Proof):
    """Needs no robot, and asks no server."""

    async def run(self) -> Findings:
        return self._findings(await self._cut_all())

    async def _sample(self, fault: Fault, way: Order) -> Sample:
        frame_ms = self._settings.drive.max_age_ms
        return Sample(frame_ms, standing_ms=frame_ms + 50.0, speed_mps=None)


if __name__ == "__main__":
    pytest.MonkeyPatch().setattr(command, "Proof", PaperProof)
    sys.exit(main())
