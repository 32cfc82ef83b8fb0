"""The language: parser, checker and readers of asset files. The result is a TaskSpec."""
