"""Deliberate faults, and whether validation notices them."""
