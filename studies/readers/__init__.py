"""The readers' test: people who do not know the project read random docstrings and pages."""
