"""What people look at: each function gives a Figure."""
