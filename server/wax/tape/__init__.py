"""The tape: a recording on disk of what everybody saw, heard and did, kept for a limited time.

It subscribes to the fan-out and the gate like another viewer, and writes files in a thread. It
never delays anybody: what the disk is too slow for is dropped and reported.
"""
