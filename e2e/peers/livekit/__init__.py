"""LiveKit fed by WHIP, set up as its own documentation has it for robots; the lab compares with it.

`python -m e2e.peers.livekit` runs three parts: LiveKit's server, a publisher (aiortc, one layer,
as WHIP allows it) and the server of a small page that plays what is published with
livekit-client. Where its documentation gives a choice, the lowest delay is taken: playout delay
0 to 10 ms, which is its preset for teleoperation; no adaptive stream, which has one layer to
choose from and would wait until the video element is seen; no STUN, as all addresses are known.
All else is as LiveKit has it by default.
"""
