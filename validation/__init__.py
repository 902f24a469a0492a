"""Oracles that say what the right picture is, and comparisons with them (installs as `clrt_validation`)."""
