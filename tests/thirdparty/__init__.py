"""Programs that are not ours read our stages and run our native files, in environments of their own."""
