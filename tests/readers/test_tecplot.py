"""Tecplot's text: zones by points and by blocks, what titles say, files that break off."""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit.base import CampaignError
from pmmkit.readers import READERS, Options, Request, recognise

NUMBERS = np.array([[0.0, 1.5, -2.0], [0.1, 1.25, -2.5], [0.2, 1.0, -3.0], [0.3, 0.5, 1e-3]])
HEAD = 'TITLE = "static drift"\nVARIABLES = "Time (s)" "Fx (N)"\n"Fy (N)"\n'


def points(numbers=NUMBERS, form="{:.6E}"):
    return "".join(" ".join(form.format(x) for x in row) + "\n" for row in numbers)


def request(tmp_path, text, group=None, name="run.dat"):
    (tmp_path / name).write_bytes(text.encode("latin-1") if isinstance(text, str) else text)
    return Request(path=tmp_path / name, shown=name, options=Options(group=group))


def read(asked):
    found = READERS["tecplot"].columns(asked, lambda headers, count: range(count))
    return found.headers, np.column_stack(found.values)


FORMS = {
    "points": f'{HEAD}ZONE T="a", I=4, F=POINT\n{points()}',
    "no size": f'{HEAD}ZONE T="a"\n{points()}',
    "packing": f'{HEAD}ZONE T="a"\n I=4, J=1, K=1, ZONETYPE=Ordered\n DATAPACKING=POINT\n'
    f" DT=(SINGLE SINGLE SINGLE )\n{points()}",
    "blocks": f'{HEAD}ZONE T="a", I=4, DATAPACKING=BLOCK\n{points(NUMBERS.T)}',
    "fortran": f'{HEAD}ZONE T="a", I=4\n{points().replace("E", "D")}',
    "small letters": f'title="x"\nvariables="Time (s)","Fx (N)","Fy (N)"\nzone t="a"\n{points()}',
    "bare names": f"VARIABLES = t, Fx, Fy\nZONE I=4, F=POINT\n{points()}",
    "remarks": f'# written by hand\n{HEAD}# of day two\nZONE T="a"\n# points\n{points()}# end\n',
    "windows": f'{HEAD}ZONE T="a", I=4\n{points()}'.replace("\n", "\r\n"),
    "many a line": f'{HEAD}ZONE T="a", I=4\n{points().replace(chr(10), " ")}',
    "a title in latin letters": f'{HEAD.replace("drift", "Schräg")}ZONE T="a"\n{points()}',
}


@pytest.mark.parametrize("text", FORMS.values(), ids=FORMS)
def test_a_zone_is_read_however_it_is_written(text, tmp_path):
    asked = request(tmp_path, text)
    assert recognise(asked.path) == "tecplot"
    headers, values = read(asked)
    assert [header.partition(" ")[0] for header in headers][1:] == ["Fx", "Fy"]
    np.testing.assert_array_equal(values, NUMBERS)


def test_of_several_zones_each_is_a_run(tmp_path):
    text = HEAD + "".join(
        f'ZONE T="{name}", I=4\n{points(NUMBERS + shift)}'
        for name, shift in (("beta=2 deg", 0.0), ("beta=4 deg", 1.0), ("beta=4 deg", 2.0))
    )
    asked = request(tmp_path, text)
    assert READERS["tecplot"].groups(asked) == ("beta=2 deg", "beta=4 deg", "zone 3")
    for group, shift in (("beta=2 deg", 0.0), ("beta=4 deg", 1.0), ("zone 3", 2.0)):
        np.testing.assert_array_equal(read(request(tmp_path, text, group))[1], NUMBERS + shift)
    with pytest.raises(CampaignError, match=r"no zone 'beta=3 deg'.*beta=2 deg"):
        read(request(tmp_path, text, "beta=3 deg"))


def test_titles_and_auxiliary_data_are_told(tmp_path):
    beside = 'DATASETAUXDATA speed = "1.5 m/s"\nZONE T="run 7"\nAUXDATA beta_deg = "4"\n'
    text = f"{HEAD}{beside}{points()}"
    told = READERS["tecplot"].remarks(request(tmp_path, text))
    assert told == ("static drift", "speed: 1.5 m/s", "run 7", "beta_deg: 4")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (f'{HEAD}ZONE T="a", I=5\n{points()}', "12 numbers of 3 variables of 5 points"),
        (f'{HEAD}ZONE T="a"\n{points()[:-10]}\n1.0', "cut short"),
        (f'{HEAD}ZONE T="a", I=4\n{points().replace("1.25", "1.x5")}', "is not a number"),
        (f'{HEAD}ZONE T="a", I=4\n12*0.5\n', "writes equal numbers once"),
        (f'{HEAD}ZONE T="a", N=4, E=1, F=FEPOINT\n{points()}', "finite elements"),
        (f'{HEAD}ZONE T="a", I=4\n', "no zones of numbers"),
        (b"#!TDV112" + bytes(40), "binary form"),
    ],
)
def test_what_is_no_whole_table_is_refused(text, says, tmp_path):
    with pytest.raises(CampaignError, match=says):
        read(request(tmp_path, text))


def test_a_table_whose_header_speaks_of_variables_is_no_tecplot(tmp_path):
    asked = request(tmp_path, "variables of the test\nt,X,Y,N\n0,1,2,3\n0.1,1,2,3\n")
    assert recognise(asked.path) == "csv"
