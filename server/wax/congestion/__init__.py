"""Congestion control for one viewer's link: its rate, what to send, and when. Pure.

It runs at the sender, on transport-wide feedback
(draft-holmer-rmcat-transport-wide-cc-extensions-01), as GCC does (draft-ietf-rmcat-gcc-02), but:

* Packet-train dispersion raises the rate (`delivery_rate`): pictures are sent faster than the rate
  (`pacer`), and the bottleneck spreads them to its own rate. GCC raises the rate by 8 % a second,
  BBR by a higher pacing gain; both then watch the delay.
* A standing queue as in CoDel lowers it (`queuing_delay`), to a fraction of the busy link's
  delivery rate. GCC uses the delay's gradient, not its level, and 0.85 of the received rate.
* Loss lowers it only where it is very high (`loss`); without transport-wide feedback it is the only
  signal, as in GCC section 6.
* While feedback is late, a picture is sent only every 0.3 s (`sender_side`); after two round trips
  without feedback, probing stops, too (`feedback`).

Limits: no padding is sent, so pictures of up to 200 bytes probe nothing; a competing flow's queue
counts as ours, and no mode competes with loss-based flows (GCC's adaptive threshold, SCReAM's
higher target); a settled link is only sampled (`feedback`); the base delay expires in 30 s.

`sender_side` joins all that with the pacer, behind `control`, the interface to a peer. `allocator`
chooses the step of the rendition ladder; `sound_choice`, the sound's encoding and redundancy.
`sync/` decides when media play.

A constant names its source; one without a source did best on simulated links. `make ablation`
halves and doubles each on 15 links with six seeds; its table is in `e2e/out/ablation`. Without
the parts below, this gets worse:

* Without the startup rule (`estimator._STARTUP_TRAINS`), or without splitting pictures to probe
  (`_PROBE_PACKETS`), half of the links are used half as much.
* With a loss threshold near GCC's (`loss._HIGH_LOSS_SHARE` of 12 %), a radio link that loses 16 %
  of its packets is used to 15 % instead of 100 %.
* Without the smallest step's own share (`allocator._LAST_SHARE`), thin links show far fewer
  pictures.
* Without the wait between steps (`allocator._BETWEEN_S`), the sound is 188 ms old after the rate
  has fallen, instead of 113 ms.
* With half the hold after a fall (`estimator._HOLD_S`), a cellular link is used to 55 % instead of
  61 %, and its sound is 7 ms older.
* With fewer than three recent packets (`queuing_delay._RECENT_PACKETS`), no queue is found when
  5 Mbit/s fall to 100 kbit/s.
"""
