"""Runs read once each, several at a time, and on from where one stopped."""
