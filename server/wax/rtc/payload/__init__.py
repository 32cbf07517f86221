"""How encoded picture and sound become the payloads of RTP packets: pure, a module a format.

Sending and numbering packets is up to `wax.rtc`.
"""
