"""What a run says: means and harmonics with covariance, scatter, stated uncertainties."""
