"""Campaigns of laboratories that never heard of pmmkit, of hulls whose truth is known.

Nothing here imports pmmkit: the forces, the motions, the files and the turn are written out apart.
"""
