"""Runs and campaigns: reading them, saving them, and what is known of each test."""
