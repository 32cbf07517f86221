"""Which stream waits for which, and how long: sound is the master, picture the slave (thesis 3.3).

Pure: takes `now_s`, returns targets for a browser's jitter buffers. No input or output.
"""
