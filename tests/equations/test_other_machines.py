"""Machine code for systems that are not at hand: what it asks of them, from the object code."""

from __future__ import annotations

import math
import struct

import pytest

import pmmkit as pk
from pmmkit.effects import CATALOGUE
from pmmkit.equations import compilation, integrator, lanes, prepare
from pmmkit.equations.code_generation import SAILING
from pmmkit.syntax import LlvmProgram

pytest.importorskip("numba")
llvm = pytest.importorskip("llvmlite.binding")
MACHINES = {
    "x86_64-pc-windows-msvc-elf": "x86-64",
    "arm64-apple-darwin-elf": "apple-m1",
    "aarch64-unknown-linux-gnu": "",
}
"""Objects in the form that numba loads, which names what they call; and the oldest processors."""
EVERYWHERE = {"sin", "cos", "exp", "pow", "atan2", "sqrt", "memcpy", "memset"}
OF_SOME = {"sincos", "bzero", "_GLOBAL_OFFSET_TABLE_"}
"""Linux has the first and macOS the second, where LLVM calls them; the third is none's."""
_KINDS = {"list[float]": "list", "int": "int", "float": "double"}


def asked(text, triple, processor):
    """Names that the object code of a module looks for outside of it."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    module = llvm.parse_assembly(text)
    module.triple = triple
    target = llvm.Target.from_triple(triple)
    machine = target.create_target_machine(cpu=processor, opt=3, codemodel="jitdefault")
    module.data_layout = str(machine.target_data)
    tuned = llvm.create_pipeline_tuning_options(speed_level=3)
    llvm.create_pass_builder(machine, tuned).getModulePassManager().run(
        module, llvm.create_pass_builder(machine, tuned)
    )
    made = llvm.ObjectFileRef.from_data(machine.emit_object(module))
    parts = {item.name(): item.data() for item in made.sections()}
    words = parts[b".strtab"]
    return {
        words[at : words.index(b"\0", at)].decode()
        for at, _, _, section, *_ in struct.iter_unpack("<IBBHQQ", parts[b".symtab"])
        if at and not section
    }


@pytest.mark.parametrize("triple", MACHINES)
@pytest.mark.parametrize("name", ["kvlcc2-l7", "esso-osaka-3m", "s175"])
def test_equations_ask_of_a_system_what_it_has(name, triple):
    model = pk.load_model(name)
    structure = prepare(model, model.ship.speed(0.142)).structure
    program = LlvmProgram(*compilation._source(structure, SAILING), "")
    for function in (integrator.run, lanes.run_many):
        given = [x for word, x in function.__annotations__.items() if word != "return"]
        program.take(function.__name__, [_KINDS[x] for x in given])
    # No __chkstk of Windows: no function takes more than a page of the stack.
    assert asked(program.text, triple, MACHINES[triple]) <= EVERYWHERE | OF_SOME


def windy_keel(u, v, rho, size):
    """A keel with a function that systems have under different names, or not at all."""
    return (size * rho * math.hypot(u, v) * v,)


def test_a_function_that_the_system_has_not_is_said_and_python_takes_over(monkeypatch):
    known = pk.effect(
        family="hull",
        outputs=("Y",),
        parameters=(pk.Parameter(name="size", text="m²", typical=-0.01),),
        check="static drift in steps of 1°",
    )(windy_keel)
    found = llvm.address_of_symbol
    monkeypatch.setattr(llvm, "address_of_symbol", lambda x: None if "hypot" in x else found(x))
    compilation.compiled.cache_clear()
    try:
        ship = pk.with_effect(pk.load_model("s175-3dof"), known.name, coefficients={"size": -0.01})
        turn = {"rudder_deg": 35, "speed": 9.0}
        with pytest.warns(UserWarning, match=r"interpreted.*no function _?hypot"):
            told = pk.simulate(ship, compiled=True, **turn)
        assert told.metrics == pk.simulate(ship, compiled=False, **turn).metrics
    finally:
        CATALOGUE.forget(known.name)
        compilation.compiled.cache_clear()
