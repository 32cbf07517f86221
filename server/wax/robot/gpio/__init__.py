"""A robot whose motors hang on this computer's own pins, by gpiozero.

`settings` says what is where, `shares` how far each motor is opened, `odometry` what the encoders
tell: pure. `pins` knows gpiozero, `loop` keeps the pins open in a thread, and `guard` is the
process that clears them when this one has died.
"""
