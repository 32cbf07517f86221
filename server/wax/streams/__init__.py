"""What one viewer is sent: joins their lanes, congestion control, ladder and playout policy.

`interface` is what the session knows of it; `live` is today's service, `wax.baseline` that of 2004.
"""
