"""The tunnel of `[door]`: an SSH connection to a public machine, the door, which relays the page.

ssh.py (pure) builds the command and parses ssh's messages; attempts.py (pure) decides what to try
when; tunnel.py runs ssh; over_https.py goes by TCP 443 where 22 is closed; page.py checks whether
the page opens there; line.py (pure) parses what `config/deploy/door.sh` prints.
"""
