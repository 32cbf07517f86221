"""Serves one viewer: connects lanes, congestion control, ladder and playout policy.

The session uses `interface`; `live` is the default service, `wax.baseline` the one of 2004.
"""
