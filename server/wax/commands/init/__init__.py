"""`wax init`: looks at what is plugged in, asks a little, and writes a configuration.

found.py looks; questions.py (pure) says what is asked; writing.py (pure) makes the file's text;
command.py asks, checks the text as the server would, and writes it whole or not at all.
"""
