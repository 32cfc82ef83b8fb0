"""Datasets: built, verified, attested and audited."""
