"""The interface of a robot driver, its types, and the checks that apply to every driver.

Robots implement it (`wax.robot`), the control loop calls it (`wax.control`); it imports neither.
"""
