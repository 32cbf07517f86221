"""The robots, one package for each kind, and the separate processes in which they run.

Their common interface is `wax.driver`. Nothing here knows about viewers.
"""
