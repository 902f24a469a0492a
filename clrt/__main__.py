"""`python -m clrt`."""

from clrt.cli import program

program()
