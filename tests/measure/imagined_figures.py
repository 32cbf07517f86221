"""A suite's published figures, as a test imagines them."""

from __future__ import annotations

from typing import Any

from e2e.measure.published import Published
from e2e.measure.suite import digest


def imagined(**update: Any) -> Published:
    """Return figures of version 1.2.3, measured on what has not changed since."""
    found = Published(
        suite="x",
        version="1.2.3",
        commit="abc",
        date="2026-11-22",
        machine="a machine",
        load=0.5,
        measures=[],
        measured=digest([]),
        columns=["WAX", "stock"],
        rows=[],
    )
    return found.model_copy(update=update)
