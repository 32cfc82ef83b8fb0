"""From executed episodes to questions: measured answers, options, and gates."""
