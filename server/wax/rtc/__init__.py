"""One browser is one peer: signalling, ICE, tracks and data channels, over aiortc."""
