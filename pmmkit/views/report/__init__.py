"""Reports: what a command has worked out as a page, and the test report of captive tests."""
