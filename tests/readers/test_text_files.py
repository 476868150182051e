"""Text files of columns as loggers, tanks and old programs write them."""

from __future__ import annotations

import codecs
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.base import CampaignError, DataError
from pmmkit.readers import Options, Request
from pmmkit.readers.text import csv
from pmmkit.readers.text.decoding import CUT, cut_apart

TABLE = np.array([[0.0, 1.25, -20.5], [0.5, 1.5, -21.25], [1.0, 1.75, -22.0], [1.5, 2.0, -22.75]])


@pytest.fixture
def read(tmp_path):
    """Write a file and read all of its columns; gives the columns as read."""

    def _read(content: str | bytes, encoding: str = "utf-8", **options):
        path = tmp_path / "run.txt"
        path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
        request = Request(path=path, shown="run.txt", options=Options(**options))
        return csv.columns(request, lambda headers, width: range(width))

    return _read


def rows(delimiter=" ", decimal=".", form="{:.2f}", table=TABLE, ends="\n"):
    """The table as text."""
    return "".join(
        delimiter.join(form.format(number).replace(".", decimal) for number in row) + ends
        for row in table
    )


def same(columns, table=TABLE):
    return np.array_equal(np.column_stack(columns.values), table)


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize(
    ("delimiter", "decimal"),
    [(";", ","), (";", "."), ("\t", ","), ("\t", "."), (",", "."), (" ", "."), ("  ", ",")],
)
def test_units_stand_in_a_second_line(read, delimiter, decimal, ends):
    names, units = delimiter.join(("t", "u", "X")), delimiter.join(("s", "m/s", "N"))
    found = read(f"{names}{ends}{units}{ends}" + rows(delimiter, decimal, ends=ends))
    assert found.headers == ("t [s]", "u [m/s]", "X [N]")
    assert same(found)


@pytest.mark.parametrize("delimiter", ["\t", ";"])
@pytest.mark.parametrize("ends", ["\t", " \t ", "\t\t"])
def test_names_and_units_that_end_in_a_delimiter(read, delimiter, ends):
    """As spreadsheets and loggers write them: the rows below have none."""
    tail = ends.replace("\t", delimiter)
    names, units = delimiter.join(("t", "u", "X")), delimiter.join(("s", "m/s", "N"))
    found = read(f"{names}{tail}\r\n{units}{tail}\r\n" + rows(delimiter, ends="\r\n"))
    assert found.headers == ("t [s]", "u [m/s]", "X [N]")
    assert same(found)
    assert read(f"{names}{tail}\n" + rows(delimiter)).headers == ("t", "u", "X")


@pytest.mark.parametrize(("delimiter", "decimal"), [(";", ","), (",", "."), ("\t", ".")])
@pytest.mark.parametrize("last", ["", "\n"])
def test_empty_rows_below_the_last_number_are_told_and_left(read, delimiter, decimal, last):
    """A spreadsheet writes a row for each that was ever used."""
    empty = 2 * delimiter
    found = read(
        f"t{delimiter}u{delimiter}X\n"
        + rows(delimiter, decimal)
        + f"{empty}\n{empty}\n{empty}{last}"
    )
    assert same(found)
    assert found.notes == ("the file ends in 3 rows without a number; they are not read",)


def test_empty_rows_between_numbers_are_damage(read):
    with pytest.raises(CampaignError, match="row 6: there is no value"):
        read("t,u,X\n" + rows(",") + ",,\n" + rows(","))


def test_a_row_that_ends_in_a_delimiter_is_damaged(read):
    with pytest.raises(CampaignError, match="fields"):
        read("t\tu\tX\t\n" + rows("\t") + "1.0\t2.0\t3.0\t4.0\n")


def test_units_in_brackets_and_with_blanks(read):
    found = read("Time Speed  Moment\n[s]  [m/s]  [N m]\n" + rows())
    assert found.headers == ("Time [s]", "Speed [m/s]", "Moment [N m]")


def test_columns_without_dimension_have_no_unit(read):
    found = read("t;Fn;X\ns;;N\n" + rows(";"))
    assert found.headers == ("t [s]", "Fn", "X [N]")


def test_a_line_of_units_that_pmmkit_does_not_know_must_be_stated(read):
    text = "t;p;X\ns;furlong;N\n" + rows(";")
    with pytest.raises(CampaignError, match="rows 1 and 2 may both be the names"):
        read(text)
    assert read(text, units_row=True).headers == ("t [s]", "p [furlong]", "X [N]")


def test_units_that_contradict_the_names(read):
    with pytest.raises(CampaignError, match=r"X \[N\].*row 2.*'N'.*'kN'"):
        read("t;u;X [N]\ns;m/s;kN\n" + rows(";"))
    assert read("t;u;X [N]\ns;m/s;N\n" + rows(";")).headers == ("t [s]", "u [m/s]", "X [N]")


def test_a_stated_line_of_units_must_fit_the_names(read):
    with pytest.raises(CampaignError, match="units has 2 fields, the names are 3"):
        read("t;u;X\ns;m/s\n" + rows(";"), units_row=True)
    with pytest.raises(CampaignError, match="no line of units"):
        read("t;u;X\n", units_row=True)


PREAMBLE = """Towing tank 2; measurement 117
Date: 03.04.2019 11:05
Model 4711, scale 1:36

Sample rate: 2 Hz
Channels: 3
Remark
"""


@pytest.mark.parametrize("units", ["", "s;m/s;N\n"], ids=["names", "names and units"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_the_preamble_of_a_logger_is_found(read, units, decimal):
    found = read(PREAMBLE + "Time;Speed;Force\n" + units + rows(";", decimal))
    names = ("Time [s]", "Speed [m/s]", "Force [N]") if units else ("Time", "Speed", "Force")
    assert found.headers == names
    assert same(found)
    (note,) = found.notes
    assert f"line {9 + bool(units)}, the names just above" in note


def test_a_preamble_without_names(read):
    found = read(PREAMBLE + rows("\t"))
    assert found.headers == ("", "", "")
    assert same(found)
    assert "line 8, no line of names" in found.notes[0]


def test_a_preamble_with_as_many_fields_as_the_rows(read):
    """Nobody can tell the names from it, unless something in it is no name."""
    names = "Time;u;X\n" + rows(";")
    found = read("Logger;XY 12;v3\nBy;hand;\n" + names)
    assert found.headers == ("Time", "u", "X")
    assert same(found)
    for top in ("Logger;XY 12;v3\n", "Logger;XY 12;v3\nBy;my;hand\n"):
        with pytest.raises(CampaignError, match=r"skip_rows = [12] .*units_row = true"):
            read(top + names)


def test_a_stated_number_of_lines_is_believed(read):
    assert read(PREAMBLE + "t;u;X\n" + rows(";"), skip_rows=7).notes == ()
    with pytest.raises(DataError):
        read(PREAMBLE + "t;u;X\n" + rows(";"), skip_rows=2)


def test_damaged_rows_are_no_preamble(read):
    """Rows of which some number is lost are never passed over as if they were a heading."""
    body = rows(";", table=np.vstack([TABLE, TABLE + 2]))
    lines = body.splitlines()
    lines[1] = lines[1].replace("-21.25", "abc")
    for head in ("", "t;u;X\n", PREAMBLE + "t;u;X\n", PREAMBLE):
        with pytest.raises(CampaignError):
            read(head + "\n".join(lines) + "\n")
    lines[0] = lines[0].replace("-20.50", "-20;50")
    for head in ("t;u;X\n", PREAMBLE + "t;u;X\n", PREAMBLE):
        with pytest.raises(CampaignError):
            read(head + "\n".join(lines) + "\n")
    lines[0] = lines[0].replace("-20;50", "--")
    for head in ("t;u;X\n", PREAMBLE + "t;u;X\n"):
        with pytest.raises(CampaignError):
            read(head + "\n".join(lines) + "\n")


@pytest.mark.parametrize(
    ("place", "row"),
    [(0, "0.00;1.25;-20;50"), (0, "0.00;--;--"), (0, "0.00;abc"), (2, "abc;def;ghi")],
    ids=["a field too many", "half lost", "most lost", "all lost"],
)
@pytest.mark.parametrize("head", ["t;u;X\n", "preamble"])
def test_a_damaged_row_near_the_top(read, head, place, row):
    lines = rows(";", table=np.vstack([TABLE, TABLE + 2])).splitlines()
    lines[place] = row
    top = PREAMBLE + "t;u;X\n" if head == "preamble" else head
    with pytest.raises(CampaignError):
        read(top + "\n".join(lines) + "\n")


def test_numbers_in_a_preamble_are_no_rows(read):
    found = read(PREAMBLE + "117;4711\nt;u;X\n" + rows(";"))
    assert found.headers == ("t", "u", "X")
    assert same(found)


@pytest.mark.parametrize("mark", ["#", "%", "!", "//"])
def test_comments_above_between_and_below(read, mark):
    lines = rows(" ").splitlines()
    text = "\n".join(
        [
            f"{mark} measured with care",
            f"{mark}",
            "t u X",
            *lines[:2],
            f"{mark} carriage stopped",
            *lines[2:],
            f"{mark} end of the record",
        ]
    )
    found = read(text + "\n")
    assert found.headers == ("t", "u", "X")
    assert same(found)
    assert found.notes == ("comments among the rows left out: 2 lines",)


@pytest.mark.parametrize("mark", ["#", "%", "!", "//"])
def test_names_and_units_in_comments(read, mark):
    top = f"{mark} run 12, third\n{mark} t u X\n"
    assert read(top + rows()).headers == ("t", "u", "X")
    assert read(top + f"{mark} s m/s N\n" + rows()).headers == ("t [s]", "u [m/s]", "X [N]")
    assert read(top + f"{mark} -----\n" + rows()).headers == ("t", "u", "X")
    below = read(PREAMBLE + f"t u X\n{mark} started again after a break\n" + rows())
    assert below.headers == ("t", "u", "X")
    assert read(f"{mark} run 12\n" + rows()).headers == ("", "", "")


def test_a_row_that_begins_like_a_comment_is_damaged(read):
    """One changed bit turns 1, 3 and 5 into !, # and %."""
    text = "t,u,X\n" + rows(",")
    with pytest.raises(CampaignError, match=r"row 4.*'!\.00'"):
        read(text.replace("\n1.00", "\n!.00"))
    found = read(text.replace("\n1.00", "\n!.00"), comment="!")
    assert same(found, TABLE[[0, 1, 3]])
    assert found.notes == ("comments among the rows left out: 1 lines",)


def test_lines_are_counted_with_comments(read):
    lines = rows(";").splitlines()
    text = "\n".join(
        ["t;u;X", "# one", lines[0], "# two", "# three", lines[1].replace("1.50", "?")]
    )
    with pytest.raises(CampaignError, match="row 6"):
        read(text + "\n" + lines[2] + "\n")


def test_columns_that_touch(read):
    """FORTRAN's F8.2,2F7.2 fills its columns: nothing stands between them."""
    table = TABLE - [0, 0, 1000]
    body = "".join("{:8.2f}{:7.2f}{:8.2f}\n".format(*row) for row in table)
    assert " -" not in body
    found = read("    Time  Speed   Force\n" + body, widths=(8, 7, 8))
    assert found.headers == ("Time", "Speed", "Force")
    assert same(found, table)
    assert same(read(body.replace("\n", "\r\n"), widths=(8, 7, 8)), table)
    assert same(read("Größe von Lauf 7\n" + body, widths=(8, 7, 8), skip_rows=1), table)
    decimal = read(body.replace(".", ","), widths=(8, 7, 8))
    assert same(decimal, table)


def test_lines_of_fixed_width_that_do_not_fit(read):
    body = "".join("{:8.2f}{:7.2f}{:8.2f}\n".format(*row) for row in TABLE)
    lines = body.splitlines()
    with pytest.raises(CampaignError, match=r"row 3.*4 fields, too many"):
        read("\n".join([*lines[:2], lines[2] + "7", lines[3]]) + "\n", widths=(8, 7, 8))
    with pytest.raises(CampaignError, match=r"column 3, row 4: there is no value"):
        read("\n".join([*lines[:3], lines[3][:15]]) + "\n", widths=(8, 7, 8))
    with pytest.raises(CampaignError, match="one or the other"):
        read(body, widths=(8, 7, 8), delimiter=";")


@given(
    st.lists(st.lists(st.text("°äab1.- ", max_size=9), min_size=3, max_size=3), max_size=6),
    st.tuples(*[st.integers(1, 9)] * 3),
)
def test_fields_of_fixed_width_are_the_slices_of_the_line(table, widths):
    lines = [
        "".join(cell[:width].ljust(width) for cell, width in zip(row, widths, strict=True))
        for row in table
    ]
    cut = cut_apart("\n".join(lines).encode(), widths).decode().split("\n")
    for line, fields in zip(lines, cut, strict=False):
        a, b = widths[0], widths[0] + widths[1]
        expected = [line[:a], line[a:b], line[b:]] if line.strip() else [line]
        assert fields.split(CUT) == expected


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-8-sig"])
def test_texts_with_a_byte_order_mark(read, encoding):
    mark = {"utf-16-le": codecs.BOM_UTF16_LE, "utf-16-be": codecs.BOM_UTF16_BE}.get(encoding, b"")
    text = "t [s];beta [°];X [N]\r\n" + rows(";", ",", ends="\r\n")
    found = read(mark + text.encode(encoding))
    assert found.headers == ("t [s]", "beta [°]", "X [N]")
    assert same(found)


def test_half_a_character_of_utf_16(read):
    text = ("t;u;X\n" + rows(";")).encode("utf-16")
    with pytest.raises(CampaignError, match="not utf-16 text"):
        read(text[:-1])
    with pytest.raises(CampaignError, match="zero bytes"):
        read(text[2:])


def test_a_heading_in_cp1252_is_read_and_noted(read):
    found = read("t [s];beta [°];X [N]\n" + rows(";", ","), encoding="cp1252")
    assert found.headers == ("t [s]", "beta [°]", "X [N]")
    assert same(found)
    assert found.notes == ("the heading is not UTF-8 and was read as cp1252",)


def test_rows_that_are_not_utf_8_are_refused(read):
    text = "t [s];beta [°];X [N]\n" + rows(";", ",") + "2,0;1,5;-2³,0\n"
    with pytest.raises(CampaignError, match=r"row 1.*0xb0.*encoding = \"cp1252\""):
        read(text, encoding="cp1252")


@pytest.mark.parametrize("cell", ["1,234.5", "1 234.5", "-12'345.0", "1,234,567"])
def test_thousands_separators_are_refused(read, cell):
    text = "t;u;X\n" + rows(";") + f"2.0;1.5;{cell}\n"
    with pytest.raises(CampaignError, match=r"row 6.*thousands separators"):
        read(text)


def test_thousands_separators_beside_a_decimal_comma(read):
    text = "t;u;X\n" + rows(";", ",") + "2,0;1,5;1.234,5\n"
    with pytest.raises(CampaignError, match=r"row 6.*thousands separators"):
        read(text)


def test_commas_that_may_be_either(read):
    text = "t;X\n1;1,250\n2;1,500\n3;12,750\n"
    with pytest.raises(CampaignError, match=r"'1,250' is 1\.250 .* and 1250 with"):
        read(text)
    table = np.array([[1, 1.25], [2, 1.5], [3, 12.75]])
    assert same(read(text, decimal=","), table)
    assert same(read(text.replace("12,750", "0,750")), np.array([[1, 1.25], [2, 1.5], [3, 0.75]]))


def test_the_same_numbers_by_the_fast_and_the_careful_way(read):
    """Comments and preambles do not decide about numbers; quotes lead to the careful way."""
    rng = np.random.default_rng(0)
    table = rng.normal(size=(500, 4)) * 10.0 ** rng.integers(-5, 9, (500, 4))
    body = rows(";", form="{!r}", table=table.tolist())
    plain = read("a;b;c;d\n" + body)
    assert same(plain, table)
    assert same(read('a;b;c;d\n"' + body.replace(";", '";', 1)), table)
    assert same(read(PREAMBLE + "a;b;c;d\n" + body.replace("\n", "\n# again\n", 3)), table)


@pytest.mark.slow
def test_flipped_bits_below_a_preamble(read):
    """One bit changed: refused, or the same shape with at most one other number."""
    table = np.round(np.random.default_rng(1).normal(size=(40, 4)), 4)
    body = rows(";", form="{:.4f}", table=table)
    whole = bytearray((PREAMBLE + "t;u;X;N\n" + body).encode())
    start = len(PREAMBLE) + 8
    rng = np.random.default_rng(2)
    read_well = 0
    for place, bit in zip(
        rng.integers(start, len(whole), 250), rng.integers(0, 8, 250), strict=True
    ):
        broken = bytearray(whole)
        broken[place] ^= 1 << int(bit)
        try:
            found = read(bytes(broken))
        except DataError:
            continue
        read_well += 1
        assert len(found.values[0]) == len(table)
        assert np.sum(np.column_stack(found.values) != table) <= 1
    assert read_well > 20


def test_rows_of_runs_keep_their_text(tmp_path: Path):
    """Tables whose rows are runs: text in cells is no reason to look for a preamble."""
    path = tmp_path / "runs.csv"
    path.write_text("Run;Remark;X\n7;first;-1.5\n8;waves, ended;-2.5\n9;;-3.5\n")
    found = csv.cells(Request(path=path, shown="runs.csv"))
    assert found.headers == ("Run", "Remark", "X")
    assert [row[1] for row in found.rows] == ["first", "waves, ended", ""]
    assert found.notes == ()


@pytest.mark.parametrize("head", ["", "C  RUN 7\nC      T[S]      U[M/S]     FX[N]\n"])
@pytest.mark.parametrize("power", ["D", "d"])
def test_fortran_writes_d_before_the_power_of_ten(read, head, power):
    """Its comments have a C in the first place, names among them."""
    found = read(head + rows("  ", form="{:.6E}").replace("E", power))
    assert found.headers == (("T[S]", "U[M/S]", "FX[N]") if head else ("", "", ""))
    assert same(found)


def test_a_d_elsewhere_stays_what_it_is(read):
    found = read("t [s],FX 3.D-23 [N],run2D-1 [N]\n" + rows(","))
    assert found.headers[2] == "run2D-1 [N]"
    assert same(found)
