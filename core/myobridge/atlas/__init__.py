"""Stability atlas: hard cases as data, tried with every installed method that goes with them."""

from myobridge.atlas.atlas import Atlas
from myobridge.atlas.catalogue import QUANTITIES
from myobridge.atlas.cell import Cell, Finding
from myobridge.atlas.chart import Chart
from myobridge.atlas.frequencies import exact_largest_frequency
from myobridge.atlas.quantities import PathGauge, RunGauge

__all__ = ["QUANTITIES", "Atlas", "Cell", "Chart", "Finding", "PathGauge", "RunGauge", "exact_largest_frequency"]
