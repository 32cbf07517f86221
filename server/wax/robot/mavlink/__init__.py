"""A ground rover or boat with ArduPilot, by MAVLink.

`vehicle` is what is known of it, `failsafe` what it promises for the time without us, `mapping` and
`schedule` what it is told and when: all pure. `codec` knows pymavlink, `line` and `link` sockets,
ports and threads.
"""
