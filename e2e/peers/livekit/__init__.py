"""LiveKit, a peer, in two ways that its own documentation has.

`python -m e2e.peers.livekit` runs LiveKit's server, publishes to it, and serves a small page that
plays what is published with livekit-client.

* ``--how sdk``, its quick start: published by its Python SDK with simulcast, adaptive stream and
  dynacast on in the page, all else as LiveKit has it by default.
* ``--how whip``, its lowest delay for one layer: published by WHIP from aiortc, which cannot do
  simulcast; a playout delay of 0 to 10 ms, which is its preset for teleoperation; no adaptive
  stream, since it has only one layer to choose from and would wait until the video element is
  visible.

No STUN with either, as all addresses are known.
"""
