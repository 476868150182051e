"""Jobs, a file each: its settings and what it does. Command of the same name."""
