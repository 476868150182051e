"""What a release needs beside the code: bounds that are true, pinned versions, a bill of them."""
