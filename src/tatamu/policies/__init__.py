"""Folds for policies: environments of Gymnasium and datasets."""
