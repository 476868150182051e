"""What people look at: each function gives a matplotlib Figure and changes nothing global."""
