"""Scripts about pmmkit: set-up, data sets, benchmarks, studies, documentation."""
