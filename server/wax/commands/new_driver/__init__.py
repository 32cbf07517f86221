"""`wax new-driver`: a package with a robot driver, its table, its test and a robot to try it on."""
