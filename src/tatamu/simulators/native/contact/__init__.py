"""Contact of cloth with itself and with the table."""
