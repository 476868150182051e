"""Kinds of test: each is defined once, in the file of its family, and everything else asks it."""
