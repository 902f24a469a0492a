"""The rays of a pixel as a tree: what each brings, and files that show it. Knows no device."""
