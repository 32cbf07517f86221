"""`wax doctor`: what the world can reach, and what this machine can do, checked one by one."""
