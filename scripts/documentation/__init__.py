"""What docs/ takes from the program."""
