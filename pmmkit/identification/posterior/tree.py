"""Draws of a posterior as an xarray.DataTree in the layout of ArviZ, as NetCDF, and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, Problem, __version__
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.effects import CURRENT
from pmmkit.files import atomic_path, is_intact
from pmmkit.identification.posterior.density import DEGREES, PROCESS_NOISE, SENSOR_SCALE, Density
from pmmkit.identification.posterior.ensembles import EnsembleDraws
from pmmkit.identification.record import FreeRecord
from pmmkit.numerics import Array
from pmmkit.readers import declared_bytes, open_hdf5
from pmmkit.simulation import Draws

if TYPE_CHECKING:
    import xarray as xr

PRIOR_DRAWS: Final = 1000
"""Draws from the prior that are kept beside."""
LARGEST: Final = 2**30
"""Bytes of a file above which it is not read."""
GROWTH: Final = 4
"""Times the size of the file that its content may take."""
_NOT_READ: Final = "The posterior is not read"


def tree_of(
    density: Density,
    records: Sequence[FreeRecord],
    found: EnsembleDraws,
    everything: Mapping[str, Array],
    seed: int,
) -> xr.DataTree:
    """Groups of ArviZ: posterior, sample_stats, prior, observed_data, constant_data, and how well
    the ensembles agree.

    everything (e, t, w).

    Notes
    -----
    A chain is an ensemble. Its draws are those of all walkers at every so many steps, after which
    a walker has forgotten where it was: they count as nearly independent.
    """
    import xarray as xr

    kept = slice(found.time - 1, None, found.time)
    steps = np.arange(found.left_out, found.steps)[kept, None]
    stats: dict[str, NDArray[Any]] = {
        "lp": found.log_density[:, kept],
        "log_likelihood": found.more[:, kept, :, 0],
        "step": np.broadcast_to(steps, found.log_density[:, kept].shape),
    }
    told = {
        "creation_library": "pmmkit",
        "creation_library_version": __version__,
        "inference_library": "emcee",
        "converged": int(found.convergence.reached),
        "seed": seed,
    }
    agreement = found.convergence
    groups = {
        "posterior": _drawn({name: x[:, kept] for name, x in everything.items()}),
        "sample_stats": _drawn(stats).assign(accepted=("chain", found.accepted)),
        "prior": _drawn(_before(density, everything, seed)),
        "observed_data": _measured(records, lambda item: item.measured),
        "constant_data": _measured(records, _inputs),
        "convergence": xr.Dataset(
            {
                name: ("parameter", getattr(agreement, name))
                for name in ("r_hat", "ess_bulk", "ess_tail")
            },
            coords={"parameter": list(agreement.names)},
        ),
    }
    return xr.DataTree.from_dict({"/": xr.Dataset(attrs=told), **groups})


def _drawn(values: Mapping[str, NDArray[Any]]) -> xr.Dataset:
    """Arrays (e, t, w) with dimensions chain and draw."""
    import xarray as xr

    flat = {name: x.reshape(len(x), -1) for name, x in values.items()}
    chains, draws = next(iter(flat.values())).shape
    return xr.Dataset(
        {name: (("chain", "draw"), x) for name, x in flat.items()},
        coords={"chain": np.arange(chains), "draw": np.arange(draws)},
    )


def _before(density: Density, names: Mapping[str, Array], seed: int) -> dict[str, Array]:
    """Draws from the prior of all that was drawn."""
    rng = np.random.default_rng([seed, PRIOR_DRAWS])
    own = density.parameters(rng.standard_normal((1, PRIOR_DRAWS, 1, len(density.names))))
    found = {name: own[..., i] for i, name in enumerate(density.names)}
    found[SENSOR_SCALE] = np.sqrt(DEGREES / rng.chisquare(DEGREES, (1, PRIOR_DRAWS, 1)))
    return {name: found[name] for name in names}


def _inputs(record: FreeRecord) -> Mapping[str, Array]:
    return {"delta": record.delta, "n": record.turns}


def _measured(records: Sequence[FreeRecord], what: Any) -> xr.Dataset:
    """Columns of all records, one after another, with the number of the record of each instant."""
    import xarray as xr

    columns = [dict(what(item)) for item in records]
    names = list(dict.fromkeys(name for own in columns for name in own))
    sizes = [len(item) for item in records]
    joined = {
        name: np.concatenate(
            [own.get(name, np.full(n, np.nan)) for own, n in zip(columns, sizes, strict=True)]
        )
        for name in names
    }
    return xr.Dataset(
        {name: ("instant", x, {"units": CHANNEL_UNITS.get(name, "")}) for name, x in joined.items()}
        | {"record_index": ("instant", np.repeat(np.arange(len(records)), sizes))},
        coords={
            "t": ("instant", np.concatenate([item.t for item in records]), {"units": "s"}),
            "record": ("record", [item.name for item in records]),
        },
    )


def draws_of(tree: xr.DataTree) -> Draws:
    """The parameters' draws, for `monte_carlo` and `Bands.of` in place of a spread."""
    beside = (PROCESS_NOISE, SENSOR_SCALE, *CURRENT)
    data = tree["posterior"].to_dataset()
    names = tuple(str(name) for name in data.data_vars if name not in beside)
    values = np.stack([data[name].to_numpy().ravel() for name in names], axis=1)
    doubt = "" if tree.attrs.get("converged", 1) else ", NOT converged"
    return Draws(names=names, values=values, origin=f"{len(values)} draws of a posterior{doubt}")


def write_posterior(tree: xr.DataTree, path: str | Path) -> None:
    """Write the draws as NetCDF4, which ArviZ reads; the same draws give the same bytes."""
    with atomic_path(path, sealed=True) as part:
        tree.to_netcdf(part, engine="h5netcdf")


def read_posterior(path: str | Path) -> xr.DataTree:
    """Read what `write_posterior` wrote.

    Notes
    -----
    As with tables, the seal is looked at before the file is opened. So a file that
    another program has saved again is not read here, but by ``xarray.open_datatree``.
    """
    import xarray as xr

    name = str(path)
    remedy = "Write the file again."

    def refused(why: str) -> DataError:
        return DataError(Problem(message=why, file=name, remedy=remedy), title=_NOT_READ)

    try:
        size = Path(path).stat().st_size
        if size > LARGEST:
            raise refused(f"is of {size / 2**20:.0f} MB, which is too large for draws.")
        intact = is_intact(path)
    except OSError as error:
        raise refused(f"cannot be read: {error}") from error
    if intact is None:
        raise refused("is no posterior that pmmkit wrote: it has no checksum.")
    if not intact:
        raise refused("is damaged: its checksum is another.")
    try:
        with open_hdf5(Path(path)) as raw:
            if "posterior" not in raw:
                raise refused("has no group posterior.")
            if declared_bytes(raw) > GROWTH * size:
                raise refused("declares far more than it holds.")
        with xr.open_datatree(path, engine="h5netcdf") as opened:
            return opened.load()
    except DataError:
        raise
    except Exception as error:
        raise refused(f"is no readable posterior ({type(error).__name__}: {error}).") from error
