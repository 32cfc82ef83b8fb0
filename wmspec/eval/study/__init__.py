"""Studies with people: page, server, and results."""
