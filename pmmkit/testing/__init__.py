"""Contracts: what every entry of a registry must hold; run them over your own."""
