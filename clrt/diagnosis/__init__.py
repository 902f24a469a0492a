"""What is wrong with a machine, and what mends it."""
