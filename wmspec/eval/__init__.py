"""Evaluation of models and people: models, replies, exports, studies, reports."""
