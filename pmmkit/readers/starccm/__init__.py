"""Exports of Simcenter STAR-CCM+."""
