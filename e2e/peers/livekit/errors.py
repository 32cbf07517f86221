"""Errors of this peer."""

from __future__ import annotations


class LiveKitError(Exception):
    """A sentence for a person: what is wrong and what to do."""
