"""The learned fold: what its folder holds."""
