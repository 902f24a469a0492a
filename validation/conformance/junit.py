"""The self-test's results as JUnit XML, for build servers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from clrt.base.atomic import replacing
from clrt.base.errors import one_line

_NAME = "clrt selftest"


def write_junit(path: Path, results: Sequence[Any], about: Mapping[str, str]) -> None:
    """Write a test case for each check; `about`: the driver and the machine, as properties."""
    root = ElementTree.Element("testsuites", name=_NAME)
    failed = sum(not result.passed for result in results)
    suite = ElementTree.SubElement(root, "testsuite", name=about.get("device", _NAME),
                                   tests=str(len(results)), failures=str(failed))  # fmt: skip
    suite.set("time", f"{sum(result.seconds for result in results):.3f}")
    properties = ElementTree.SubElement(suite, "properties")
    for name, value in about.items():
        ElementTree.SubElement(properties, "property", name=name, value=one_line(value))
    for result in results:
        case = ElementTree.SubElement(suite, "testcase", classname=_NAME, name=result.name,
                                      time=f"{result.seconds:.3f}")  # fmt: skip
        if not result.passed:
            kernel = f"kernel {result.fault.kernel}: " if result.fault else ""
            ElementTree.SubElement(case, "failure", message=one_line(kernel + result.detail))
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
