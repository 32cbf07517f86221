"""A model of the Java client of 2004 and of what it was served, beside the thesis's figures."""
