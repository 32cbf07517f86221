"""`wax init`: detects what is plugged in, asks a few questions, and writes a configuration.

found.py detects devices; questions.py (pure) has the questions; writing.py (pure) renders the file;
command.py asks, checks the text as the server would, and writes it whole or not at all.
"""
