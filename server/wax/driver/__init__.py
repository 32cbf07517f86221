"""The interface of a robot driver, its types, and the checks that apply to every driver.

Robots implement the interface (`wax.robot`) and the control loop calls it (`wax.control`); this
package imports neither.
"""
