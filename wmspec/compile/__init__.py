"""From a TaskSpec to instances and USD stages: design, layout, robots, stage; lint rules."""
