"""Reads the test card off the presented frame and out of the played sound, on any WebRTC page.

The known residual errors; `error.own_error` measures what can be measured:

* Unix time in the page: ± 0.5 ms (``page/clock.js``).
* Picture: timed when the browser gives the frame to its compositor, at a display refresh; the time
  to the screen is not included (``page/video_probe.js``). The card's stamp is in whole ms: 0.5 ms.
* Sound: recorded from a device, a null sink of PulseAudio (`e2e.measure.ear`), whichever browser
  and player. The device plays in steps of 2 ms, transferred at their start, which is taken into
  account; with steps of 5 ms the same ages are found within 4 ms.
* A burst's begin in Opus is smeared by 2.5 to 5 ms, alike in every system with the same codec.

No script of ours is loaded under the page's policy, so its CSP stays.
"""

from __future__ import annotations

from e2e.instrument.instrument import PRELOAD, Instrument

__all__ = ["PRELOAD", "Instrument"]
