"""Synchronisation of sound and picture: the sound is the master (thesis 3.3).

Pure: takes `now_s`, returns targets for the browser's jitter buffers. No input or output.
"""
