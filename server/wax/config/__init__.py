"""The configuration file: every key with its type, range and default.

`config/wax.toml` is the manual. Nothing here uses the clock, a device or the network.
"""
