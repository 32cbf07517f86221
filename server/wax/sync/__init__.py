"""Pure: which stream waits for which, and how long. Sound is the master, picture the slave."""
