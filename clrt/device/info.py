"""What is known of an OpenCL device."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DeviceInfo:
    """One OpenCL device, as `clrt devices` lists it. `memory` is in bytes, `units` counts compute units."""

    index: int
    name: str
    platform: str
    version: str
    kind: str
    units: int
    memory: int
    driver: str = ""
    """The driver's own version, beside that of the OpenCL it speaks."""

    @property
    def label(self) -> str:
        return f"{self.platform} {self.version} / {self.name}"
