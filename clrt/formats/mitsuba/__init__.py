"""Mitsuba's XML: a scene from its plugins, one module a kind of them."""
