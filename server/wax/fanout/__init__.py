"""From one encoder to many viewers: a hub for each kind of media, a lane for each viewer.

A lane is bounded and drops what is stale; a slow viewer affects only their own lane. Congestion
control decides what a lane carries.
"""
