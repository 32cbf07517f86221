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
chooses the step of the rendition ladder; `sound_choice`, the sound's encoding and redundancy.
`sync/` decides when it plays.

Each constant names its source; "ours" did best on simulated links. `make ablation` halves and
doubles each on 15 links with six seeds; its table is in `e2e/out/ablation`. Without

* the start's own rule (`estimator._STARTUP_TRAINS`) or pictures split in order to probe
  (`_PROBE_PACKETS`), half of the links are used half as much;
* the allowance for jitter (`dispersion._COMPRESSED_NOISES`), poor LTE is used by 53, not 94 %;
* the usual loss (`loss._USUAL_FACTOR`), a radio that loses 16 % by 15, not 100 %;
* the smallest step's own share (`allocator._LAST_SHARE`), thin links show far fewer pictures;
* the hold after a fall (`estimator._HOLD_S`), a cell gains 8 points, but its sound is 20 ms older.

`allocator.FIT_SHARE` and `_KEEP_SHARE` up to 0.15 higher change less than chance, and so does it to
take out most of the waits.
"""
