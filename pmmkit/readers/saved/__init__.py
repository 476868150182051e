"""Campaigns that pmmkit saved."""
