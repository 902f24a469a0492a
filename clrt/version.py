"""The one place that names the version; pyproject.toml and the metadata of every picture read it."""

__version__ = "0.1.0"
