"""Statistical tests of a dataset for completeness, imbalance, duplicates and shortcuts."""
