"""The documentation site, gathered from the README, docs/ and the program."""
