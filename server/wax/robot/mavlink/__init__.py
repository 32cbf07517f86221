"""A ground rover or boat with ArduPilot, by MAVLink.

`rover` holds what is known of the rover and why it may not be driven, `failsafe` its behaviour when
our link is lost, `mapping` and `schedule` what to send and when: all pure. `conversation` decides
whether to send anything. `codec` uses pymavlink; `line` and `link` use sockets, ports and threads.
"""
