"""Datasets on disk: questions as rows, rows in Parquet shards, shards in a folder that other tools open."""
