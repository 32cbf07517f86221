"""A client of the protocol without a browser: signalling, media, data channels, driving.

`Client` connects and watches as a page does; `Operator` drives as well. Their media are received
and counted, never decoded; `Follower` decodes the picture. The server itself imports nothing here.
"""

from __future__ import annotations

from wax.client.client import Client
from wax.client.follower import Follower
from wax.client.operator import Operator

__all__ = ["Client", "Follower", "Operator"]
