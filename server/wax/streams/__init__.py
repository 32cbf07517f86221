"""What one viewer is sent: connects lanes, congestion control, ladder and playout policy.

The session uses `interface`; `live` is the default service, `wax.baseline` that of 2004.
"""
