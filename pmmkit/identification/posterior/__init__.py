"""The posterior of a model's parameters, drawn by ensembles of walkers."""

from pmmkit.identification.posterior.posterior import Posterior, sample_posterior
from pmmkit.identification.posterior.tree import draws_of, read_posterior, write_posterior

__all__ = ["Posterior", "draws_of", "read_posterior", "sample_posterior", "write_posterior"]
