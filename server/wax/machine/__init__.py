"""What the operating system is asked for: memory, further Python processes, systemd."""
