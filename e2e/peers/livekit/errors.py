"""What this peer says when it cannot do something."""

from __future__ import annotations


class LiveKitError(Exception):
    """A sentence for a person: what is wrong and what to do."""
