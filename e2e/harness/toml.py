"""Configurations that several tests start a server with."""

from __future__ import annotations

CARD = """
[video]
source = "testcard"
[audio]
source = "testcard"
"""
"""Picture and sound that can be read back; everything else as shipped."""

BRIEF_GRACE = "grace_s = 0.5"
"""Who closes his page is forgotten soon, so that the next test need not wait for his turn."""


def card(codec: str) -> str:
    """Encode the test card with one of the two video codecs."""
    return CARD.replace("[audio]", f'codec = "{codec}"\n[audio]')


def card_with(**sections: str) -> str:
    """Add tables to the test card, as ``turns="turn_s = 3.0"``; ``__`` in a name is a dot."""
    tables = [f"[{name.replace('__', '.')}]\n{keys}\n" for name, keys in sections.items()]
    return CARD + "\n".join(tables)
