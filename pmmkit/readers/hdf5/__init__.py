"""HDF5 and NetCDF files of any origin."""
