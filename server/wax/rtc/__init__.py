"""One browser is one peer: signalling, ICE, tracks and data channels, over aiortc.

Private parts of aiortc are touched in `private` only. What is sent, and when, is asked of lanes
and congestion control; no policy lives here.
"""
