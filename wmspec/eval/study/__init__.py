"""People as raters: a study of a dataset's questions, its page, its server, and what came of it."""
