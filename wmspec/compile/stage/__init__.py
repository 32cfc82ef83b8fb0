"""From an instance to a USD stage: one base layer per task, one override layer per instance or counterfactual."""
