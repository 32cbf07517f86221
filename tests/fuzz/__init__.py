"""Any bytes from a stranger, for every parser: a value or the one declared error, and no motion.

``make fuzz`` searches at length, guided by coverage; the tests replay what it found (`corpus`) and
try up to ten thousand inputs of a seeded mutator, a tenth of them in `make test`.
"""
