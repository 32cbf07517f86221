"""Congestion control for one viewer's link: its rate, what to send, and when. Pure, without clock.

It runs at the sender, on transport-wide feedback
(draft-holmer-rmcat-transport-wide-cc-extensions-01), as GCC does (draft-ietf-rmcat-gcc-02), but:

* The rate rises by packet-train dispersion (`delivery_rate`): pictures leave faster than the rate
  (`pacer`), and the bottleneck spreads them, which bounds its own. GCC raises it by 8 % a second,
  BBR by a higher pacing gain; both then watch the delay.
* A standing queue as in CoDel lowers it (`queuing_delay`), to a fraction of the busy link's
  delivery rate. GCC: the delay's gradient, not its level, and 0.85 of the received rate.
* Loss lowers it only where it is very high (`loss`); without transport-wide feedback it is the only
  signal, as in GCC section 6.
* Where feedback is late, a picture leaves only each 0.3 s (`sender_side`); after two round trips
  probing stops, too (`feedback`).

Limits: no padding is sent, so pictures of up to 200 bytes probe nothing; a competing flow's queue
counts as ours, and no mode competes with loss-based flows (GCC's adaptive threshold, SCReAM's
higher target); a settled link is only sampled (`feedback`); the base delay expires in 30 s.

`sender_side` joins all that with the pacer, behind `control`, the interface to a peer. `allocator`
chooses the step of the rendition ladder; `sound_choice`, the sound's encoding and redundancy.
`sync/` decides when it plays.

A constant names its source; one without a source did best on simulated links. `make ablation`
halves and doubles each on 15 links with six seeds; its table is in `e2e/out/ablation`. Without

* the start's own rule (`estimator._STARTUP_TRAINS`) or pictures split in order to probe
  (`_PROBE_PACKETS`), half of the links are used half as much;
* a bound of loss far above GCC's (`loss._HIGH_LOSS_SHARE`; 12 % instead), a radio that loses 16 %
  is used by 15, not 100 %;
* the smallest step's own share (`allocator._LAST_SHARE`), thin links show far fewer pictures;
* the wait between steps (`allocator._BETWEEN_S`), after a fall of the rate the sound is 188, not
  113 ms old;
* half of the hold after a fall (`estimator._HOLD_S`), a cell is used by 55, not 61 %, and its sound
  is 7 ms older;
* three recent packets at least (`queuing_delay._RECENT_PACKETS`), no queue is found where 5 Mbit/s
  fall to 100 kbit/s.
"""
