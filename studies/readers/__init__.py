"""The readers' test: random docstrings and pages for people who do not know the project."""
