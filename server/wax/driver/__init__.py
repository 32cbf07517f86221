"""What a robot is to WAX: the interface, its values, and what is checked of every driver.

Robots implement it (`wax.robot`), the control loop calls it (`wax.control`); it imports neither.
"""
