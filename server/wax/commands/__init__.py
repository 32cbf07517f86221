"""What `wax` does besides serving, a package for each longer command; `wax.__main__` chooses."""
