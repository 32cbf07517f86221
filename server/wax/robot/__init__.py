"""The robots, one package for each kind, and the processes in which they run apart.

Their common interface is `wax.driver`. Nothing here knows about viewers.
"""
