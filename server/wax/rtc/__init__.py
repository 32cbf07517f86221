"""One peer per browser: signalling, ICE, tracks and data channels, over aiortc.

Only `private` and `private_association` touch private parts of aiortc. Lanes and congestion control
decide what is sent, and when; there is no policy here.
"""
