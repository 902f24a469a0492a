"""Exercises: a fault planted in a copy of the kernels, for a student to find and mend."""
