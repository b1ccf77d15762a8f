"""Settings that all tests share."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

# Deadlines are timings, and timings are benchmarks. Compiled kernels make the first example slow.
settings.register_profile("default", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("default")
