"""The configuration file: every key with its purpose, type, range and default.

`config/wax.toml`, the manual, is written from these modules by `make manual`. Nothing here uses the
clock, a device or the network.
"""
