"""People's own photographs and clips as rows of a dataset, so that all that reads datasets works on them."""
