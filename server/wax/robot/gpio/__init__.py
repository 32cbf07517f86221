"""A robot whose motors are wired to this computer's GPIO pins, driven through gpiozero.

`settings` says what is wired where, `shares` computes each motor's duty cycle, `odometry` evaluates
the encoders: all pure. `pins` uses gpiozero, `pin_line` is what a thread does with them, and
`guard` is the process that switches them off if this one dies.
"""
