"""A ground rover or boat with ArduPilot, by MAVLink.

`rover` is what is known of it and why it may not be driven, `failsafe` what it promises for the
time without us, `mapping` and `schedule` what it is told and when: all pure. `conversation` says
whether it is told anything. `codec` knows pymavlink, `line` and `link` sockets, ports and threads.
"""
