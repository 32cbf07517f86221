"""A client of the protocol without a browser: signalling, media, data channels, driving.

`Client` connects and watches as a page does; `Operator` drives as well. Media are received and
counted, never decoded. Nothing here is imported by the server itself.
"""

from __future__ import annotations

from wax.client.client import Client
from wax.client.operator import Operator

__all__ = ["Client", "Operator"]
