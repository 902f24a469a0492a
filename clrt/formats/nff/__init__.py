"""NFF, the Neutral File Format of Haines' Standard Procedural Databases, in and out."""
