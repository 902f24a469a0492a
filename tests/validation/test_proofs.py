"""The large proofs in short, and that they would find what they look for."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from clrt import layout
from clrt.base.resources import kernel_folder, validation_module

proofs = validation_module("proofs")


def test_no_ray_leaks_through_shared_edges_and_corners() -> None:
    proof = proofs.leaks(proofs.Prover(batch=1 << 17), 1_000_000)
    assert proof.rays >= 1_000_000
    assert proof.failed == 0


def test_no_leaving_ray_meets_its_own_surface() -> None:
    proof = proofs.self_hits(proofs.Prover(batch=1 << 13), 1_000_000)
    assert proof.rays >= 1_000_000
    assert proof.failed == 0


def test_triangles_without_their_edges_leak(tmp_path: Path, hasty: None) -> None:
    kernels = shutil.copytree(kernel_folder(), tmp_path / "kernels")
    source = (kernels / "triangle.clh").read_text()
    closed = "(e.x >= 0.0f) & (e.y >= 0.0f) & (e.z >= 0.0f)) | ((e.x <= 0.0f) & (e.y <= 0.0f) & (e.z <= 0.0f)"
    assert source.count(closed) == 1
    (kernels / "triangle.clh").write_text(source.replace(closed, closed.replace("=", "")))
    assert proofs.leaks(proofs.Prover(batch=1 << 14, kernels=kernels), 1).failed > 100


def test_polygons_without_their_edges_leak(tmp_path: Path, hasty: None) -> None:
    kernels = shutil.copytree(kernel_folder(), tmp_path / "kernels")
    source = (kernels / "polygon.clh").read_text()
    assert source.count("odd | on") == 1
    (kernels / "polygon.clh").write_text(source.replace("odd | on", "odd"))
    assert proofs.leaks(proofs.Prover(batch=1 << 14, kernels=kernels), 1).failed > 100


def test_rays_that_start_on_the_surface_meet_it(monkeypatch: pytest.MonkeyPatch, hasty: None) -> None:
    monkeypatch.setattr(layout, "OFFSET", 0.0)
    assert proofs.self_hits(proofs.Prover(batch=1 << 10), 1).failed > 1000
