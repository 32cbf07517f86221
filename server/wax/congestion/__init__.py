"""Congestion control for one viewer's link: its rate, what to send, and when. Pure, without clock.

It runs at the sender, on transport-wide feedback
(draft-holmer-rmcat-transport-wide-cc-extensions-01), as GCC does (draft-ietf-rmcat-gcc-02), but:

* The rate rises by packet-train dispersion (Keshav, SIGCOMM 1991; Dovrolis, Ramanathan and Moore,
  INFOCOM 2001): pictures leave faster than the estimated rate, and the bottleneck spreads them,
  which bounds its rate (`probing`, `packet_trains`, `dispersion`). GCC raises it by 8 % a second,
  BBR by a higher pacing gain; both then watch the delay.
* A standing queue as in CoDel (RFC 8289) lowers it: the minimum queuing delay of recent packets
  (`standing_queue`), above a base delay as in LEDBAT (RFC 6817), NADA (RFC 8698) and SCReAM
  (RFC 8298) (`queuing_delay`). GCC follows the gradient of the delay, not its level.
* It falls to a fraction of the busy link's delivery rate (`delivery_rate`); GCC's falls to 0.85 of
  the received rate.
* Loss lowers it only where it is much higher than usual (`loss`); without transport-wide feedback,
  loss is the only signal (`loss_based`, GCC section 6).
* Without feedback for two round trips, probing stops and pictures pause (`feedback_timeout`).

Limits: no padding is sent, so pictures that fit one packet probe nothing; a competing flow's queue
counts as ours, and no mode competes with loss-based flows (GCC's adaptive threshold, SCReAM's
higher target); a settled link is only sampled (`feedback_sampling`); the base delay expires after
half a minute, without draining the queue.

`sender_side` joins all that with the pacer, behind `control`, the interface to a peer. `allocator`
chooses the step of the rendition ladder; `sound_choice`, the sound's form and redundancy. `sync/`
decides when it plays.

Each constant names its source; "ours" did best on the lab's links. `make ablation` halves and
doubles each in simulation: for 94 of the 175 neither matters to speak of. What matters most is how
much of the rate a step may take (`allocator.FIT_SHARE`, `_KEEP_SHARE`), how far the rate falls and
when it rises (`estimator._DECREASE_FACTOR`, `_MIN_RISE_FACTOR`, `_STARTUP_S`), how certain a
train's dispersion must be (`dispersion._ERRORS`), how long a queue must stand
(`standing_queue._MIN_SPAN_S`) and when a competing flow's queue counts as full
(`sender_side._FULL_QUEUE_MS`).
"""
