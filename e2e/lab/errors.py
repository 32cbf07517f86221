"""What the lab says when a cell cannot be done."""

from __future__ import annotations


class LabError(Exception):
    """A sentence for a person: what did not work and what to do; a log's end may follow it."""


class NotRunError(LabError):
    """It cannot run on this machine: why, and what would have to be installed or allowed."""
