"""Robots: kinematics, and planners that turn actions into joint or base trajectories."""
