"""Tables in files: the same when read back, readable by others, and never read when damaged."""

from __future__ import annotations

import csv
import json
import math
import random
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pmmkit.base import TableError
from pmmkit.conventions import Convention, Ship, Water
from pmmkit.models import DerivativeTable, from_values, read_table, write_table
from pmmkit.models.tables.compare import identical
from pmmkit.models.tables.io import to_latex

DATA = Path(__file__).parents[1] / "data"
SUFFIXES = ("csv", "nc", "h5", "xlsx")
COLUMNS = ["Fn", "derivative", "value", "std", "ci_low", "ci_high", "method", "runs"]
SHIP = Ship(
    name='S175 "1:36", µ', L=4.861111, B=0.705556, d=0.236111, volume=0.454861, mass=454.476,
    Izz=618.332, xG=-0.07, GM=0.0083, block_stated=0.559,
)  # fmt: skip


def example(pooled: bool = False) -> DerivativeTable:
    """Three Froude numbers, a value that is not known, correlations across everything."""
    names = ("Xuu", "Yv", "Yv|v|", "Nvvr", "Yvdot")
    k, n = (1 if pooled else 3), len(names)
    i = np.arange(1.0, k * n + 1)
    value = (np.sin(i) / 7).reshape(k, n)
    covariance = (np.cos(np.subtract.outer(i, i)) + np.eye(k * n)).reshape(k, n, k, n) * 1e-6
    value[0, 3] = np.nan
    covariance[0, 3] = np.nan
    covariance[:, :, 0, 3] = np.nan
    dof = np.where(i % 4 == 0, np.inf, 3.5 + i).reshape(k, n)
    return DerivativeTable(
        names=names,
        Fn=np.array([np.nan]) if pooled else np.array([0.1448, 0.2172, 0.2896]),
        value=value,
        covariance=covariance,
        dof=dof,
        method=np.array([["fit, weighted", "=balance", "a\nb", "", "global"]] * k),
        runs=np.arange(k * n, dtype=np.int64).reshape(k, n),
        convention=Convention(system="prime-d", sway="beta", moment_reference_x=-0.07),
        ship=SHIP,
        water=Water(rho=999.1, nu=1.14e-6),
        notes=("Yv and Yv|v| move together (ρ = -.97).", 'second "note"\nwith a line'),
        provenance={"file": "s175.h5", "hashes": ["ab", "cd"], "settings": {"cycles": 3}},
    )


finite = st.floats(allow_nan=False, allow_infinity=False, width=64)


@st.composite
def tables(draw) -> DerivativeTable:
    pooled = draw(st.booleans())
    k = 1 if pooled else draw(st.integers(1, 3))
    names = draw(
        st.lists(
            st.sampled_from(["Yv", "Nr", "X0", "Kphi", "Nv|v|", "Yd", "XT"]),
            min_size=1,
            max_size=3,
            unique=True,
        )
    )
    n = len(names)
    value = np.array(draw(st.lists(finite | st.just(np.nan), min_size=k * n, max_size=k * n)))
    root = np.array(
        draw(st.lists(st.floats(-1e3, 1e3), min_size=(k * n) ** 2, max_size=(k * n) ** 2))
    ).reshape(k * n, k * n)
    text = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), max_size=8)
    speeds = draw(st.lists(st.floats(0, 2), min_size=k, max_size=k, unique=True))
    table = from_values(
        dict(zip(names, value.reshape(k, n).T, strict=True)),
        Fn=None if pooled else sorted(speeds),
        ship=SHIP,
        water=Water(depth=draw(st.none() | st.floats(0.1, 10))),
        notes=draw(st.lists(text, max_size=2)),
    )
    return table.with_(
        covariance=(root @ root.T).reshape(k, n, k, n),
        dof=np.full((k, n), draw(st.floats(1, 1e6) | st.just(np.inf))),
        method=np.array([[draw(text) for _ in names]] * k).reshape(k, n),
    )


class TestReadBack:
    @pytest.mark.parametrize("suffix", SUFFIXES)
    @pytest.mark.parametrize("pooled", [False, True])
    def test_the_same(self, tmp_path, suffix, pooled):
        table = example(pooled)
        back = read_table(write_table(table, tmp_path / f"t.{suffix}"))
        assert identical(back, table)
        assert back.provenance == table.provenance

    @pytest.mark.slow
    @pytest.mark.parametrize("suffix", ["csv", "nc", "xlsx"])
    @given(table=tables())
    @settings(
        max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
    )
    def test_the_same_whatever_it_holds(self, tmp_path, suffix, table):
        assert identical(read_table(write_table(table, tmp_path / f"t.{suffix}")), table)

    @pytest.mark.slow
    def test_the_same_table_gives_the_same_bytes_in_another_process(self, tmp_path):
        code = (
            "import sys; sys.path.insert(0, sys.argv[1]); import test_tables_files as t;"
            "[t.write_table(t.example(), name) for name in sys.argv[2:]]"
        )
        suffixes = [*SUFFIXES, "tex"]
        others = [tmp_path / f"b.{suffix}" for suffix in suffixes]
        command = [sys.executable, "-c", code, str(Path(__file__).parent), *others]
        subprocess.run(command, check=True)
        unlike = []
        for suffix, other in zip(suffixes, others, strict=True):
            own = write_table(example(), tmp_path / f"a.{suffix}")
            unlike += [suffix] * (other.read_bytes() != Path(own).read_bytes())
        assert unlike == []

    @pytest.mark.parametrize("suffix", SUFFIXES)
    def test_an_older_file_is_replaced_and_nothing_else_is_left(self, tmp_path, suffix):
        write_table(example(pooled=True), tmp_path / f"t.{suffix}")
        assert identical(read_table(write_table(example(), tmp_path / f"t.{suffix}")), example())
        extra = {"t.json"} if suffix == "csv" else set()
        assert {path.name for path in tmp_path.iterdir()} == {f"t.{suffix}"} | extra

    def test_odd_provenance_is_kept_as_text(self, tmp_path):
        table = from_values(
            {"Yv": 1.0},
            ship=SHIP,
            water=Water(),
            provenance={"path": Path("a/b"), "n": np.int64(3), "x": math.inf},
        )
        back = read_table(write_table(table, tmp_path / "t.nc"))
        assert back.provenance == {"path": str(Path("a/b")), "n": 3, "x": "inf"}


class TestSavedByVersionOne:
    """Files of the first schema, written once and kept."""

    @pytest.mark.parametrize("suffix", ["csv", "nc", "xlsx"])
    def test_they_load(self, suffix):
        assert identical(read_table(DATA / f"table_v1.{suffix}"), example())


class TestOthersRead:
    def test_pandas_reads_the_csv(self, tmp_path):
        table = example()
        frame = pd.read_csv(write_table(table, tmp_path / "t.csv"))
        assert list(frame.columns) == COLUMNS
        np.testing.assert_allclose(frame["value"], table.value.ravel(), rtol=1e-15)
        np.testing.assert_allclose(frame["Fn"], np.repeat(table.Fn, 5), rtol=1e-15)
        assert frame["derivative"].tolist() == list(table.names) * 3

    def test_the_column_fn_of_a_pooled_table_is_empty(self, tmp_path):
        text = write_table(example(pooled=True), tmp_path / "t.csv").read_text(encoding="utf-8")
        assert text.splitlines()[1].startswith(",Xuu,0.12")

    def test_intervals_are_those_of_student(self, tmp_path):
        """With 9 degrees of freedom 95 % lie within 2.262 standard deviations (any t table)."""
        table = from_values({"Yv": 1.0}, std={"Yv": 0.1}, ship=SHIP, water=Water())
        table = table.with_(dof=np.array([[9.0]]))
        frame = pd.read_csv(write_table(table, tmp_path / "t.csv"))
        assert frame["ci_low"][0] == pytest.approx(1 - 0.2262, abs=5e-5)
        assert frame["ci_high"][0] == pytest.approx(1 + 0.2262, abs=5e-5)

    def test_the_json_is_json(self, tmp_path):
        write_table(example(), tmp_path / "t.csv")

        def no_constant(name):
            raise AssertionError(f"{name} is not JSON")

        text = (tmp_path / "t.json").read_text(encoding="utf-8")
        content = json.loads(text, parse_constant=no_constant)
        assert content["convention"]["system"] == "prime-d"
        assert content["covariance"][0][3] is None

    @pytest.mark.slow
    @pytest.mark.parametrize("suffix", ["nc", "h5"])
    def test_xarray_reads_the_netcdf_as_the_table_shows_itself(self, tmp_path, suffix):
        table = example()
        with xr.open_dataset(
            write_table(table, tmp_path / f"t.{suffix}"), engine="h5netcdf"
        ) as data:
            xr.testing.assert_identical(data.load(), table.to_xarray())
            chosen = data["value"].sel(derivative="Yv", Fn=0.2172).item()
        assert chosen == table["Yv"][1]

    def test_h5py_reads_it_too(self, tmp_path):
        table = example()
        with h5py.File(write_table(table, tmp_path / "t.h5")) as file:
            np.testing.assert_array_equal(file["covariance"][...], table.covariance)
            assert file["derivative"].asstr()[...].tolist() == list(table.names)
            assert json.loads(file.attrs["ship"])["L"] == SHIP.L

    def test_pandas_reads_the_workbook(self, tmp_path):
        table = example()
        sheets = pd.read_excel(
            write_table(table, tmp_path / "t.xlsx"),
            sheet_name=None,
            na_values=[""],
            keep_default_na=False,
            engine="calamine",
        )
        assert list(sheets) == ["derivatives", "covariance", "about"]
        frame = sheets["derivatives"]
        assert list(frame.columns) == [*COLUMNS, "dof"]
        np.testing.assert_array_equal(frame["value"], table.value.ravel())
        covariance = sheets["covariance"].set_index(sheets["covariance"].columns[0])
        assert covariance.loc["Yv @ 0.1448", "Xuu @ 0.2172"] == table.covariance[0, 1, 1, 0]

    def test_no_text_of_the_workbook_is_a_formula(self, tmp_path):
        with zipfile.ZipFile(write_table(example(), tmp_path / "t.xlsx")) as archive:
            sheets = [name for name in archive.namelist() if "worksheets/" in name]
            assert len(sheets) == 3
            assert not any(b"<f>" in archive.read(name) for name in sheets)


class TestLatex:
    def test_values_with_their_uncertainty_grouped_by_channel(self):
        table = from_values(
            {"Xuu": -0.0004226, "Yv": [-0.0116, -0.01234], "Yvvr": np.nan, "Nrdot": -0.000419},
            std={"Yv": [0.000234, 0.00099], "Nrdot": 0.0000021},
            Fn=[0.145, 0.29],
            ship=SHIP,
            water=Water(),
        )
        rows = to_latex(table).splitlines()
        assert rows[0] == r"\begin{tabular}{lrr}"
        assert r"$Y'_{v}$ & $-0.01160(23)$ & $-0.01234(99)$ \\" in rows
        assert r"$Y'_{vvr}$ & -- & -- \\" in rows
        assert r"$N'_{\dot{r}}$ & $-0.0004190(21)$ & $-0.0004190(21)$ \\" in rows
        assert rows.count(r"\midrule") == 3

    def test_plus_minus_and_the_drift_angle(self):
        table = from_values(
            {"Yvvr": 0.4},
            std={"Yvvr": 0.0997},
            ship=SHIP,
            water=Water(),
            convention=Convention(system="bis", sway="beta"),
        )
        assert r"$Y''_{\beta \beta r}$ & $0.40 \pm 0.10$ \\" in to_latex(table, style="plus-minus")

    def test_braces_and_dollars_are_balanced(self, tmp_path):
        text = write_table(example(), tmp_path / "t.tex").read_text(encoding="utf-8")
        assert text.count("{") == text.count("}")
        assert text.count("$") % 2 == 0
        assert {row.count("&") for row in text.splitlines() if "&" in row} == {3}


def csv_rows(path: Path) -> list[list[str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.reader(stream))


def save_rows(path: Path, rows: list[list[str]]) -> Path:
    with path.open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows(rows)
    return path


PLAIN = [
    COLUMNS,
    ["0.1", "Yv", "-0.01", "0.001", "-0.012", "-0.008", "fit", "5"],
    ["0.1", "Xrv", "0.003", "", "", "", "fit", "2"],
    ["0.2", "Yv", "-0.012", "0.001", "-0.014", "-0.010", "fit", "5"],
    ["0.2", "Xvr", "", "", "", "", "fit", "0"],
]


class TestCsvAlone:
    def test_it_reads_with_its_uncertainties_and_says_what_is_assumed(self, tmp_path):
        table = read_table(save_rows(tmp_path / "t.csv", PLAIN))
        assert table.names == ("Yv", "Xvr")
        np.testing.assert_array_equal(table["Yv"], [-0.01, -0.012])
        np.testing.assert_array_equal(table.std, [[0.001, np.nan], [0.001, np.nan]])
        assert table.covariance[0, 0, 1, 0] == 0
        assert any("Convention assumed" in note for note in table.notes)

    def test_the_user_says_what_it_means(self, tmp_path):
        meaning = {"convention": Convention(system="bis"), "ship": SHIP, "water": Water()}
        table = read_table(save_rows(tmp_path / "t.csv", PLAIN), **meaning)
        assert (table.convention, table.ship, table.water) == tuple(meaning.values())
        assert len(table.notes) == 1

    def test_rows_in_any_order_with_windows_line_ends_and_a_byte_order_mark(self, tmp_path):
        lines = [",".join(row) for row in (PLAIN[0], *PLAIN[:0:-1])]
        path = tmp_path / "t.csv"
        path.write_bytes(("\ufeff" + "\r\n".join(lines) + "\r\n\r\n").encode())
        table = read_table(path)
        np.testing.assert_array_equal(table.Fn, [0.1, 0.2])
        np.testing.assert_array_equal(table["Yv"], [-0.01, -0.012])

    def test_what_was_read_alone_can_be_kept_in_full(self, tmp_path):
        table = read_table(save_rows(tmp_path / "t.csv", PLAIN))
        assert identical(read_table(write_table(table, tmp_path / "u.nc")), table)

    def changed(self, tmp_path, row, column, text):
        rows = [list(cells) for cells in PLAIN]
        rows[row][COLUMNS.index(column)] = text
        return save_rows(tmp_path / "t.csv", rows)

    @pytest.mark.parametrize(
        ("row", "column", "text", "words"),
        [
            (1, "value", "abc", "'abc' is not a number"),
            (1, "value", "nan", "'nan' is not a number"),
            (1, "value", "1e999", "not a number"),
            (1, "value", "-0,01", "decimal point"),
            (1, "ci_low", "0.5", "wrong side"),
            (1, "std", "-0.001", "negative"),
            (1, "Fn", "-0.1", "negative"),
            (1, "runs", "2.5", "number of runs"),
            (1, "runs", "", "number of runs"),
            (1, "derivative", "Zv", "not the name of a derivative"),
            (1, "derivative", "Yw", "not the name of a derivative"),
            (1, "derivative", "", "not the name of a derivative"),
            (2, "derivative", "Yv", "stands already in row 2"),
            (4, "Fn", "", "empty in some rows"),
            (4, "Fn", "0.3", "no row for"),
        ],
    )
    def test_a_wrong_cell_is_named(self, tmp_path, row, column, text, words):
        path = self.changed(tmp_path, row, column, text)
        with pytest.raises(TableError, match=re.escape(words)) as caught:
            read_table(path)
        assert str(path) in str(caught.value)
        if "no row" not in words and "already" not in words:
            assert any(
                problem.column == column and str(row + 1) in str(problem.row)
                for problem in caught.value.problems
            )

    def test_all_wrong_cells_at_once(self, tmp_path):
        rows = [list(cells) for cells in PLAIN]
        rows[1][2], rows[2][1], rows[4][7] = "x", "Q", "-3"
        rows[3].append("more")
        with pytest.raises(TableError) as caught:
            read_table(save_rows(tmp_path / "t.csv", rows))
        assert [problem.row for problem in caught.value.problems] == [2, 3, 4, 5]

    def test_missing_unknown_and_doubled_columns(self, tmp_path):
        rows = [list(cells) for cells in PLAIN]
        rows[0] = ["Fn", "derivative", "value", "std", "std", "ci_high", "method", "count"]
        with pytest.raises(TableError) as caught:
            read_table(save_rows(tmp_path / "t.csv", rows))
        text = str(caught.value)
        assert "column ci_low, row 1: is missing" in text
        assert "column runs, row 1: is missing" in text
        assert "column std, row 1: stands twice" in text
        assert "column count, row 1: is not a column" in text

    @pytest.mark.parametrize(
        ("content", "words"),
        [
            (b"", "holds no rows"),
            (",".join(COLUMNS).encode(), "no rows below the header"),
            ("Fn,derivative\n0.1,Y\xe9".encode("cp1252"), "row 2: is not UTF-8"),
            ("Fn,derivative".encode("utf-16"), "not UTF-8"),
            (b'Fn,"derivative\n', "not CSV"),
            (b"Fn,deriv\x00ative\n1,2", "deriv"),
        ],
    )
    def test_what_is_no_table(self, tmp_path, content, words):
        path = tmp_path / "t.csv"
        path.write_bytes(content)
        with pytest.raises(TableError, match=words):
            read_table(path)


class TestCsvAndItsJson:
    def test_a_changed_value_is_noticed(self, tmp_path):
        path = write_table(example(), tmp_path / "t.csv")
        rows = csv_rows(path)
        rows[3][2] = repr(float(rows[3][2]) * (1 + 1e-15))
        save_rows(path, rows)
        with pytest.raises(TableError, match=r"changed or damaged since.*remove t\.json"):
            read_table(path)

    def test_a_changed_std_is_named(self, tmp_path):
        path = write_table(example(), tmp_path / "t.csv")
        rows = csv_rows(path)
        rows[3][3] = "0.0015"
        save_rows(path, rows)
        with pytest.raises(TableError, match=r"column std, row 5: 0\.0015 does not follow"):
            read_table(path)

    def test_a_lost_block_of_rows_is_noticed(self, tmp_path):
        path = write_table(example(), tmp_path / "t.csv")
        save_rows(path, csv_rows(path)[:11])
        with pytest.raises(TableError, match=r"t\.json"):
            read_table(path)

    @pytest.mark.parametrize("content", ["", "{", "[]", "null", "{}", "[" * 100_000, '{"Fn": 1}'])
    def test_a_broken_json(self, tmp_path, content):
        path = write_table(example(), tmp_path / "t.csv")
        (tmp_path / "t.json").write_text(content, encoding="utf-8")
        with pytest.raises(TableError, match=r"t\.json"):
            read_table(path)

    @pytest.mark.parametrize(
        ("key", "value", "words"),
        [
            ("schema", 2, "schema is 2"),
            ("kind", "recipe", "kind"),
            ("notes", "one", "notes"),
            ("provenance", [], "provenance"),
            ("ship", {"name": "x"}, "ship.L is missing"),
            ("water", {"rho": "wet"}, "water.rho = 'wet'"),
            ("convention", {"system": "imperial"}, "convention.system"),
            ("convention", {"systeme": "prime"}, "convention.systeme is not known"),
            ("dof", [1, 2], "dof is not a list of 3 x 5"),
            ("fingerprint", "00", "changed or damaged"),
        ],
    )
    def test_a_wrong_entry_is_named(self, tmp_path, key, value, words):
        path = write_table(example(), tmp_path / "t.csv")
        sidecar = tmp_path / "t.json"
        content = json.loads(sidecar.read_text(encoding="utf-8")) | {key: value}
        sidecar.write_text(json.dumps(content), encoding="utf-8")
        with pytest.raises(TableError, match=re.escape(words)):
            read_table(path)

    def test_an_edit_can_be_kept_on_purpose(self, tmp_path):
        path = write_table(example(), tmp_path / "t.csv")
        sidecar = tmp_path / "t.json"
        content = json.loads(sidecar.read_text(encoding="utf-8"))
        content["ship"]["L"] = 5.0
        del content["fingerprint"]
        sidecar.write_text(json.dumps(content), encoding="utf-8")
        with pytest.raises(TableError, match="fingerprint is missing"):
            read_table(path)
        sidecar.write_text(json.dumps(content | {"fingerprint": None}), encoding="utf-8")
        table = read_table(path)
        assert table.ship.L == 5.0
        assert any("edited" in note for note in table.notes)


def damaged(content: bytes, rng: random.Random) -> bytes:
    """A few bytes flipped, lost, doubled or zeroed, or the file cut off."""
    kind = rng.choice(["flip", "cut", "lose", "double", "zero"])
    place = rng.randrange(len(content))
    length = rng.randint(1, 40)
    if kind == "cut":
        return content[:place]
    if kind == "lose":
        return content[:place] + content[place + length :]
    if kind == "double":
        return content[: place + length] + content[place:]
    changed = bytearray(content)
    if kind == "zero":
        changed[place : place + length] = bytes(len(changed[place : place + length]))
    else:
        for _ in range(rng.randint(1, 3)):
            changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


class TestDamage:
    """Whatever happens to a file, reading gives an error of ours or exactly what was written."""

    @pytest.mark.slow
    @pytest.mark.parametrize("seed", range(10))
    @pytest.mark.parametrize(
        ("suffix", "victim"), [("csv", "csv"), ("csv", "json"), ("nc", "nc"), ("xlsx", "xlsx")]
    )
    def test_an_error_or_the_right_answer(self, tmp_path, seed, suffix, victim):
        path = write_table(example(), tmp_path / f"t.{suffix}")
        target = tmp_path / f"t.{victim}"
        whole = target.read_bytes()
        rng = random.Random(f"{suffix} {victim} {seed}")
        refused = 0
        for _ in range(20):
            target.write_bytes(damaged(whole, rng))
            try:
                table = read_table(path)
            except TableError:
                refused += 1
            else:
                assert identical(table, example())
        assert refused >= 5

    @pytest.mark.parametrize("suffix", SUFFIXES)
    @pytest.mark.parametrize("content", [b"", b"\x00" * 600, b"PK\x03\x04", b"\x89HDF\r\n\x1a\n"])
    def test_files_of_another_kind(self, tmp_path, suffix, content):
        path = tmp_path / f"t.{suffix}"
        path.write_bytes(content)
        with pytest.raises(TableError, match=path.name):
            read_table(path)

    def test_a_netcdf_saved_again_by_another_program(self, tmp_path):
        with xr.open_dataset(write_table(example(), tmp_path / "t.nc"), engine="h5netcdf") as data:
            data.load().to_netcdf(tmp_path / "again.nc", engine="h5netcdf")
        assert identical(read_table(tmp_path / "again.nc"), example())

    def test_a_changed_value_in_such_a_file_is_noticed(self, tmp_path):
        changed = example().to_xarray()
        changed["value"][0, 0] += 1e-9
        changed.to_netcdf(tmp_path / "t.nc", engine="h5netcdf")
        with pytest.raises(TableError, match="changed or damaged since"):
            read_table(tmp_path / "t.nc")

    def test_a_netcdf_that_is_no_table(self, tmp_path):
        xr.Dataset({"value": ("t", [1.0])}).to_netcdf(tmp_path / "t.nc", engine="h5netcdf")
        with pytest.raises(TableError, match=r"column covariance: is missing"):
            read_table(tmp_path / "t.nc")

    def test_a_workbook_that_is_no_table(self, tmp_path):
        pd.DataFrame({"a": [1]}).to_excel(tmp_path / "t.xlsx", sheet_name="derivatives")
        with pytest.raises(TableError, match="has no sheet covariance"):
            read_table(tmp_path / "t.xlsx")


class TestPaths:
    @pytest.mark.parametrize("suffix", SUFFIXES)
    def test_no_such_file(self, tmp_path, suffix):
        with pytest.raises(TableError, match="no such file"):
            read_table(tmp_path / f"t.{suffix}")

    def test_unknown_suffixes(self, tmp_path):
        with pytest.raises(TableError, match=r"\.csv, \.nc, \.h5, \.xlsx, \.tex"):
            write_table(example(), tmp_path / "t.mat")
        with pytest.raises(TableError, match=r"Known: \.csv, \.nc, \.h5, \.xlsx\."):
            read_table(tmp_path / "t.tex")

    @pytest.mark.parametrize("suffix", [*SUFFIXES, "tex"])
    def test_a_path_that_cannot_be_written(self, tmp_path, suffix):
        (tmp_path / "file").write_text("in the way")
        with pytest.raises(TableError, match="cannot be written"):
            write_table(example(), tmp_path / "file" / f"t.{suffix}")

    @pytest.mark.parametrize("suffix", SUFFIXES)
    def test_an_interrupted_write_leaves_the_old_file(self, tmp_path, suffix, monkeypatch):
        path = write_table(example(), tmp_path / f"t.{suffix}")

        def interrupt(*_):
            raise KeyboardInterrupt

        monkeypatch.setattr("pmmkit.files.places.os.replace", interrupt)
        with pytest.raises(KeyboardInterrupt):
            write_table(example(pooled=True), path)
        monkeypatch.undo()
        assert identical(read_table(path), example())
        assert not list(tmp_path.glob("*.part*"))
