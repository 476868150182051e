"""Functions as LLVM."""
