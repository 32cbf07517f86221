"""A robot whose motors are wired to this computer's GPIO pins, driven through gpiozero.

`settings` says what is wired where, `shares` computes each motor's duty cycle, `odometry` evaluates
the encoders: all pure. `pins` uses gpiozero, `loop` keeps the pins open in a thread, and `guard` is
the process that switches them off if this one dies.
"""
