"""The same episodes in several engines: how far trajectories part, whether answers agree, and why they do not."""
