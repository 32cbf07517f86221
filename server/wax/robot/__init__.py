"""The robots: simulated, serial, somebody's plug-in, and the process that a driver lives in.

What every robot has in common is `wax.driver`. Nothing here knows of viewers or media.
"""
