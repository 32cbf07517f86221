"""When a page is notified of what it is sent."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from wax.congestion.allocation import Allocation
from wax.congestion.control import LinkEstimate
from wax.sentence import Sentence
from wax.streams.served_notifier import ServedNotifier

NOTHING = Allocation(None, 0, None, 0, Sentence("sent.no_picture"))
LINK = LinkEstimate("steady", 2e6, 1e6, 0.0, 1.0, 0.0, 0, 20.0)


def test_figures_that_did_not_change_are_not_computed_again_until_they_are_due() -> None:
    """A new figure goes out on the next whole second, however long the last one held."""
    messages: list[object] = []
    page: Any = SimpleNamespace(send=messages.append)
    notifier = ServedNotifier(page)

    def told(now_s: float, rate_bps: float) -> int:
        estimate = replace(LINK, rate_bps=rate_bps)
        notifier.notify(estimate, NOTHING, in_step=True, cameras=[], now_s=now_s)
        return len(messages)

    assert [told(at_s, 2e6) for at_s in (0.0, 0.5, 1.0)] == [1, 1, 1]
    assert [told(at_s, 3e6) for at_s in (1.5, 2.0)] == [1, 2]
