"""Pictures: what a render gives, and files of pictures."""
