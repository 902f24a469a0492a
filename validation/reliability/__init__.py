"""The promises of docs/reliability.md as figures: each row is one long measurement, run by one command.

    python -m validation.reliability                 run what is missing or older than the code it is about
    python -m validation.reliability --only leaks    this row anew
    python -m validation.reliability --list          the rows, and how their figures stand
    python -m validation.reliability --check         the same; fails unless all of them are good

Figures are kept one by one in docs/reliability.json, so a run that was broken off goes on where it was.
"""
