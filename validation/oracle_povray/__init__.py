"""POV-Ray as an oracle: a ray tracer that nobody here wrote, for what its scene language can express."""
