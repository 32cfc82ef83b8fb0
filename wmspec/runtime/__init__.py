"""Finding the engines and having them execute and draw what is on a stage."""
