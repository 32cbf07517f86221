"""`wax replay`: plays the tape in a browser, on a page of its own that only this machine opens."""
