"""A system beside effects that are known to be there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pmmkit.diagnosis.captive.system import Block, System


def condition_on(system: System, blocks: Sequence[Block]) -> System:
    """The system of a base that has some effects, of unknown size within their prior.

    Parameters
    ----------
    system : System
        Of the base without them.
    blocks : sequence of Block
        What the base has.

    Returns
    -------
    System
        Evidence in it is evidence beside these effects, which no longer take part.

    Notes
    -----
    With S the columns of what is known, the covariance of the data grows by S S'; of all products
    the part that S explains, with its unit prior, is taken off.
    """
    if not blocks:
        return system
    own = np.concatenate([block.places for block in blocks])
    root = np.linalg.cholesky(system.gram[np.ix_(own, own)] + np.eye(len(own)))
    centre = system.centre[own]
    across = np.linalg.solve(root, system.gram[own])
    data = system.score[own] - system.gram[np.ix_(own, own)] @ centre
    explained = np.linalg.solve(root, data)
    square = (
        system.square
        - 2.0 * float(centre @ system.score[own])
        + float(centre @ system.gram[np.ix_(own, own)] @ centre)
        - float(explained @ explained)
    )
    names = {block.candidate.name for block in blocks}
    return replace(
        system,
        gram=system.gram - across.T @ across,
        score=system.score - system.gram[:, own] @ centre - across.T @ explained,
        square=square,
        blocks=tuple(block for block in system.blocks if block.candidate.name not in names),
    )
