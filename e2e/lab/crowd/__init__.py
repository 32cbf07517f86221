"""The other viewers of a crowd: they answer as Chromium does, and count what they get.

They stand at the server's end of the link, where they load neither the link nor the browser's
decoder, and have a process of their own, so that what they cost is not the server's. A page costs
the server more by what it says than by what it hears: so there is transport-wide feedback for every
packet that asks for it, a receiver report a second, and a repeat asked for where one is missing.
"""

from __future__ import annotations

from e2e.lab.crowd.near import Crowd, crowd

__all__ = ["Crowd", "crowd"]
