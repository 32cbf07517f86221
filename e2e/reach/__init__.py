"""A small internet of namespaces: robot and friend behind routers of their own, and a relay.

`nat.py` is a router's translation of addresses (pure), `router.py` the process that moves packets
between the hosts, `internet.py` what a test enters.
"""
