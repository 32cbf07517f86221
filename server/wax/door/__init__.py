"""`[door]`: an SSH connection out to a public machine, by which the page is reached from there.

ssh.py (pure) writes the command and reads what ssh says; attempts.py (pure) decides what is tried
when; tunnel.py runs it; over_https.py goes by TCP 443 where 22 is closed; page.py looks whether the
page opens there; line.py (pure) reads what `config/deploy/door.sh` prints.
"""
