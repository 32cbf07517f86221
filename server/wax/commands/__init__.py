"""What `wax` does besides serving, a package for each command; `wax.__main__` chooses."""
