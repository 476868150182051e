"""LabVIEW files (.tdms)."""
