"""RTP payload formats for picture and sound, one module each. Pure.

`wax.rtc` numbers and sends the packets.
"""
