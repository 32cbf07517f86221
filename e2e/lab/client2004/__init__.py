"""A model of the Java client of 2004, and of what it was served: where its pauses came from."""
