"""Errors of a suite that cannot measure."""

from __future__ import annotations


class MeasureError(Exception):
    """A sentence for a person: what could not be measured, and why; the end of a log may follow."""


class NotRunError(MeasureError):
    """A sentence about what the machine lacks for this measurement, and how to get it."""
