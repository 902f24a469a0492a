"""The whole of validation in one call, and its report."""
