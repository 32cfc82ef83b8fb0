"""Import of photographs and clips as a dataset, so that all tools for datasets apply to them."""
