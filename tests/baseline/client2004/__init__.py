"""A model of the Java client of 2004 and of its server, compared with the thesis's figures."""
