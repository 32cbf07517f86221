"""One UDP port for everybody: ICE-lite, with a check of our own to each new address.

`lite_agent.py` decides and is pure; `udp_hub.py` has the sockets; `lite_connection.py` is what
aiortc talks to in place of aioice's connection.
"""
