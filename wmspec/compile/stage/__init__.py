"""USD stages of instances: one base layer per task, one override layer per instance or counterfactual."""
