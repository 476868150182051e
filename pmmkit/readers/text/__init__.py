"""Text files of columns."""
