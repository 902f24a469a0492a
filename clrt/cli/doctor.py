"""`clrt doctor`: what is wrong with this machine's OpenCL, and the command that mends it."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict

MARKS = {"fine": "  ", "advice": "? ", "wrong": "! "}


def run(options: argparse.Namespace) -> int:
    """Print every finding, and below those that are not fine what to do; return 1 when something is wrong."""
    from clrt.diagnosis.doctor import examine

    findings = examine(options.device)
    wrong = sum(finding.state == "wrong" for finding in findings)
    if options.json:
        print(json.dumps({"wrong": wrong, "findings": [asdict(finding) for finding in findings]}, indent=2))
        return 1 if wrong else 0
    width = max(len(finding.topic) for finding in findings)
    for finding in findings:
        print(f"{MARKS[finding.state]}{finding.topic:{width}}  {finding.text}")
        if finding.mend:
            print(f"  {'':{width}}  -> {finding.mend}")
    advice = sum(finding.state == "advice" for finding in findings)
    hint = f"; {advice} piece{'s' if advice > 1 else ''} of advice (?)" if advice else ""
    print(f"{wrong} fault{'s' if wrong > 1 else ''} (!)" if wrong else "nothing is wrong", end=f"{hint}\n")
    return 1 if wrong else 0
