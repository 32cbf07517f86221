"""What the suite says when it cannot measure."""

from __future__ import annotations


class FaultError(Exception):
    """A sentence for a person: what could not be measured, and why."""
