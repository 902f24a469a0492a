"""Pictures judged from Python: `clrt.compare`, and the pytest plugin that is made of it."""
