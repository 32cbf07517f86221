"""What is wrong with what somebody handed in."""

from __future__ import annotations


class TraceError(ValueError):
    """A trace that cannot be replayed; the message is a sentence for a person."""
