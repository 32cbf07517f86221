"""`wax doctor`: checks one by one what the world can reach and what this machine can do."""
