"""Pictures compared: with oracles, with other pictures, with scenes; and why they differ."""
