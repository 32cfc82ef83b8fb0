"""Datasets: generation, verification, attestation and audit."""
