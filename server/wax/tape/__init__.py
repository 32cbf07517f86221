"""The tape: what everybody saw, heard and did, on disk for a while.

One more viewer of the fan-out and one more reader of the gate, whose far end is a thread that
writes files. It never makes anybody wait: what the disk cannot take is left out, and it says so.
"""
