"""Galleries: a dataset as a page for browsing and answering."""
