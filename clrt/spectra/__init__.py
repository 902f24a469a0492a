"""Colours and spectra: how a scene states them, as curves, and in bands."""
