"""Evaluators: functions from an `Ask`, which has the parameters of a manipulation, to an `Evaluation` of the fold."""
