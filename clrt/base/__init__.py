"""What every room stands on: errors, limits, checked records, files, messages."""
