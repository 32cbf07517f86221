"""Pure: what one viewer's link carries, and what is sent over it and when. No input, no clock.

The method is congestion control at the sender, on transport-wide feedback
(draft-holmer-rmcat-transport-wide-cc-extensions-01), as GCC's (draft-ietf-rmcat-gcc-02), but:

* The rate rises by packet-train dispersion (Keshav, SIGCOMM 1991; Dovrolis, Ramanathan and Moore,
  INFOCOM 2001): pictures leave faster than the rate that is known, and how far the bottleneck has
  spread them bounds its rate (`probing`, `packet_trains`, `dispersion`). GCC raises it by 8 % a
  second, BBR by a higher pacing gain; both then watch the delay.
* It falls by a standing queue as CoDel has it (RFC 8289): the least queuing delay of what came
  lately (`standing_queue`), above a base delay as in LEDBAT (RFC 6817), NADA (RFC 8698) and SCReAM
  (RFC 8298) (`queuing_delay`). GCC follows the gradient of the delay, not its level.
* It falls to a part of the delivery rate of the busy link, as GCC to 0.85 of what was received
  (`delivery_rate`).
* Loss lowers it only where there is much more than usual (`loss`); without transport-wide feedback
  it is all there is (`loss_based`, GCC section 6).
* Without feedback for two round trips nothing is probed and pictures pause (`feedback_timeout`).

Where that departs from them: no padding is sent, so a viewer whose pictures fit one packet probes
nothing; a competing flow's queue counts as ours, and there is no mode that competes with loss-based
flows (GCC's adaptive threshold, SCReAM's higher target); a settled link is only sampled
(`feedback_sampling`); the base delay is forgotten after half a minute, without draining the queue.

`sender_side` joins all that with the pacer behind `control`, what a peer knows of it; `allocator`
chooses the step of the rendition ladder, `sound_choice` the form of the sound and its redundancy.
What decides when it plays is in `sync/`.

Each constant says where it comes from; "ours" is what did best on the lab's links. What half and
double of it change is from `make ablation`: of all simulated links the measure that changes most.
"""
