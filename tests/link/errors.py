"""Errors of links and their profiles."""

from __future__ import annotations


class LinkError(Exception):
    """A sentence for a person: what is wrong and what to do."""


class ProfileError(LinkError):
    """A profile or a trace that does not exist or cannot be used."""
