"""Published figures beside ours: one list, which a page shows and the tests check."""
