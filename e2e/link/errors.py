"""Errors of an emulator that cannot run."""

from __future__ import annotations

from tests.link.errors import LinkError


class UnavailableError(LinkError):
    """A link cannot be made on this machine, or not by this user."""
