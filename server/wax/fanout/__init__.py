"""From one encoder to many viewers: a hub for each kind of media, a lane for each viewer.

A lane is bounded and drops what is stale; a slow viewer changes their own lane only. What a lane
shall carry is decided in `wax.congestion`.
"""
