"""A driver that computes other bits: which kernel it was, with what inputs, and a program that shows it."""
