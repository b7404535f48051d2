"""Studies, which are searches for a fold by trials: their options, their loop, their storage and their results."""
