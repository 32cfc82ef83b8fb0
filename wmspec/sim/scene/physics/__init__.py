"""Time stepping shared by all engines: timelines, contacts, inertia, checks of what was simulated."""
