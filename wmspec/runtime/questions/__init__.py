"""From executed episodes to questions: measured answers, options, and the gates that an instance must pass."""
