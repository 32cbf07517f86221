"""A small internet of namespaces: robot and friend behind routers of their own, and a relay.

`wiring.py` is the process that makes them, `internet.py` what a test enters.
"""
