"""Private questions in public: questions without answers, submissions, signed receipts, and a leaderboard."""
