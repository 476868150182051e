"""FMUs in the hands of FMPy, as any other program would run them."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest

try:
    import fmpy
    from fmpy import fmi2, fmi3
except ImportError:
    fmpy = None

needs_fmpy = pytest.mark.skipif(fmpy is None, reason="FMPy is not installed")
needs_compiler = pytest.mark.skipif(
    fmpy is None or shutil.which("cc") is None, reason="there is no FMPy or no C compiler cc"
)


def exchanged(file, end: float, *, input=None, interval=1.0, tolerance=1e-9, **start) -> Any:
    """An FMU for Model Exchange, integrated by FMPy's CVode."""
    return fmpy.simulate_fmu(
        str(file),
        fmi_type="ModelExchange",
        stop_time=end,
        output_interval=interval,
        relative_tolerance=tolerance,
        start_values=start,
        input=input,
        validate=False,
    )


def steps_of(name: str, times: Sequence[float], values: Sequence[float], end: float) -> np.ndarray:
    """An input that jumps at some times, as FMPy takes it."""
    rows = []
    for i, value in enumerate(values):
        rows += [(times[i], value), (times[i + 1] if i + 1 < len(values) else end, value)]
    return np.array(rows, dtype=[("time", float), (name, float)])


class Ship:
    """An FMU for Co-Simulation, stepped by hand."""

    def __init__(self, file, folder, **start: float) -> None:
        where = fmpy.extract(str(file), str(folder))
        about = fmpy.read_model_description(where, validate=False)
        self.three = about.fmiVersion.startswith("3")
        self.places = {item.name: item.valueReference for item in about.modelVariables}
        kind = fmi3.FMU3Slave if self.three else fmi2.FMU2Slave
        self.fmu = kind(
            guid=about.guid if not self.three else about.instantiationToken,
            unzipDirectory=where,
            modelIdentifier=about.coSimulation.modelIdentifier,
            instanceName="ship",
        )
        self.messages: list[str] = []
        self.time = 0.0
        self.start = start

    def begin(self, tolerance: float = 1e-11) -> Ship:
        self.fmu.instantiate()
        if self.three:
            self.set(**self.start)
            self.fmu.enterInitializationMode(tolerance=tolerance, startTime=0.0)
        else:
            self.fmu.setupExperiment(tolerance=tolerance, startTime=0.0)
            self.set(**self.start)
            self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def set(self, **values: float) -> None:
        for name, value in values.items():
            place = [self.places[name.replace("__", ".")]]
            if isinstance(value, bool):
                self.fmu.setBoolean(place, [value])
            elif self.three:
                self.fmu.setFloat64(place, [value])
            else:
                self.fmu.setReal(place, [value])

    def get(self, *names: str) -> list[float]:
        places = [self.places[name] for name in names]
        return self.fmu.getFloat64(places) if self.three else self.fmu.getReal(places)

    def go(self, until: float) -> None:
        self.fmu.doStep(
            currentCommunicationPoint=self.time, communicationStepSize=until - self.time
        )
        self.time = until


@contextlib.contextmanager
def sailing(file, folder, **start: float) -> Iterator[Ship]:
    """A ship that has begun; its library is let go at the end."""
    ship = Ship(file, folder, **start).begin()
    try:
        yield ship
    finally:
        ship.fmu.terminate()
        ship.fmu.freeInstance()
