"""Which tests to make next: the next run, and whole programmes."""
