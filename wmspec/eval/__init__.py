"""Evaluation of models and people, reports, exports, studies, galleries and imported photographs."""
