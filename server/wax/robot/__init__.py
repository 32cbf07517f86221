"""The robots: simulated, serial, plug-in, and the driver process.

Their common interface is `wax.driver`. Nothing here knows about viewers or media.
"""
