"""A dataset as a page for people: to look at, and to answer."""
