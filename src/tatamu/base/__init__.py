"""What every room uses: errors, files, records, optional packages, curves and arrays."""
