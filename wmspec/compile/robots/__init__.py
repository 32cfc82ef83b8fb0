"""Robots: their kinematics, and the plans that make of what they do the ways of their joints."""
