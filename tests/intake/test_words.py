"""Files of laboratories that write in other languages: headers, units, names and encodings."""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS
from pmmkit.cli import main
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.intake import look
from pmmkit.intake.drafts.names import facts_of
from pmmkit.intake.guessing import suggest
from pmmkit.presentation import meanings
from pmmkit.presentation.vocabulary import vocabulary
from pmmkit.readers.text.decoding import likely_encoding

T = np.arange(0.0, 20.0, 0.05)
FILES = {
    "german": ("cp1252", ["Zeit [s]", "Längskraft [N]", "Querkraft [kN]", "Giermoment [Nm]"]),
    "german, plain": ("ascii", ["ZEIT [sek]", "Laengskraft [N]", "Querkraft [N]", "Giermoment"]),
    "japanese": ("cp932", ["時間 [秒]", "前後力 [N]", "横力 [N]", "回頭モーメント [N・m]"]),
    "japanese, unix": (
        "euc_jp",
        ["時刻 [s]", "前後力 [kgf]", "横力 [kgf]", "回頭モーメント [kgf・m]"],
    ),
    "chinese": ("gb18030", ["时间 [s]", "纵向力 [N]", "横向力 [N]", "首摇力矩 [N·m]"]),
    "korean": ("cp949", ["시간 [초]", "종방향력 [N]", "횡방향력 [N]", "회두모멘트 [N·m]"]),
    "french": ("cp1252", ["Temps (s)", "Force longitudinale", "Force latérale", "Moment de lacet"]),
    "spanish": (
        "cp1252",
        ["Tiempo", "Fuerza longitudinal", "Fuerza lateral", "Momento de guiñada"],
    ),
    "portuguese": ("utf-8", ["Tempo", "Força longitudinal", "Força lateral", "Momento de guinada"]),
}


@pytest.mark.parametrize("language", FILES)
def test_forces_of_any_laboratory_are_found(language, tmp_path):
    encoding, headers = FILES[language]
    rows = np.column_stack([T, -20 + 0 * T, np.sin(T), np.cos(T)])
    body = "\n".join(";".join(f"{x:.4f}" for x in row) for row in rows).replace(".", ",")
    text = f"{';'.join(headers)}\n{body}\n"
    (tmp_path / "run.txt").write_bytes(text.encode(encoding))
    (group,) = look(tmp_path / "run.txt").groups
    assert list(group.first.known) == ["t", "X", "Y", "N"]
    found = [column.suggestion.certainty for column in group.first.known.values()]
    assert set(found) == {"probably"}
    stated = group.first.options.encoding
    assert stated == (None if encoding in ("ascii", "utf-8") else encoding)
    assert group.first.layout.headers == tuple(headers)


@pytest.mark.parametrize("encoding", ["cp932", "euc_jp", "cp949", "gb18030", "cp1252"])
def test_every_word_tells_its_encoding_where_it_can_be_written(encoding):
    """All headers of a language together: single signs may be read in several ways."""
    scripts = {
        "cp932": ("\u30a1", "\u30ff"),
        "euc_jp": ("\u30a1", "\u30ff"),
        "cp949": ("\uac00", "\ud7a3"),
        "cp1252": ("\u00e0", "\u00ff"),
    }
    words = [word for listed in vocabulary()["channel"].values() for word in listed[:]]
    low, high = scripts.get(encoding, ("力", "力"))
    own = [word for word in words if any(low <= letter <= high for letter in word)]
    if encoding == "gb18030":
        own = ["纵向力", "横向力", "首摇力矩", "时间", "转速"]
    assert len(own) > 4
    assert likely_encoding("; ".join(own).encode(encoding)) == encoding


def test_words_stand_for_names_that_there_are():
    assert set(vocabulary()["channel"]) <= set(CHANNEL_UNITS)
    assert set(vocabulary()["setting"]) <= set(RUN_SETTINGS.units)
    assert set(vocabulary()["test"]) <= set(TEST_KINDS)
    for subject in ("channel", "test"):
        for name, words in vocabulary()[subject].items():
            for word in words:
                assert meanings(subject, word)[0][0] == name, f"{word!r} says two things"


def test_part_of_a_header_is_only_a_guess(tmp_path):
    rows = "\n".join(f"{t};{np.sin(t)};{np.cos(t)}" for t in T)
    (tmp_path / "run.txt").write_text(f"Zeit;Querkraft vorn;Querkraft hinten\n{rows}\n")
    (group,) = look(tmp_path / "run.txt").groups
    assert group.first.known["Y"].suggestion.certainty == "perhaps"


@pytest.mark.parametrize(
    ("name", "test", "stated"),
    [
        ("Schraeg_beta+00", "static_drift", {"drift_deg": 0.0}),
        ("Schrägschlepp_b-12_U1.18", "static_drift", {"drift_deg": -12.0, "speed": 1.18}),
        ("Querschwingen_T9.0s_a0.25m", "pure_sway", {"period": 9.0, "amplitude_m": 0.25}),
        ("Gieren_T9.0s_a0.25m", "pure_yaw", {"period": 9.0, "path_amplitude_m": 0.25}),
        ("Gieren_beta4_psi10deg", "yaw_drift", {"drift_deg": 4.0, "yaw_amplitude_deg": 10.0}),
        ("斜航_β+8_Fn0.142", "static_drift", {"drift_deg": 8.0, "froude": 0.142}),
        ("純左右揺/T=12.5s a=200mm", "pure_sway", {"period": 12.5, "amplitude_m": 0.2}),
        ("首摇_T8_psi6", "pure_yaw", {"period": 8.0, "yaw_amplitude_deg": 6.0}),
        ("사항시험_beta-4", "static_drift", {"drift_deg": -4.0}),
        ("lacet pur T8.0s psi6deg", "pure_yaw", {"period": 8.0, "yaw_amplitude_deg": 6.0}),
    ],
)
def test_names_of_files_in_other_languages(name, test, stated):
    found = facts_of(name)
    assert found.test == test
    assert {key: value for key, (value, _) in found.settings.items()} == pytest.approx(stated)


def test_the_message_never_recommends_what_was_just_tried(tmp_path, capsys):
    text = "時間,横力\n" + "\n".join(f"{t:.2f},{np.sin(t):.4f}" for t in T)
    (tmp_path / "run.csv").write_bytes(text.encode("cp932"))
    (tmp_path / "campaign.toml").write_text(
        '[campaign]\ntitle = "x"\n[ship]\nname = "kvlcc2-l7"\n[water]\nrho = 1000.0\n[source]\n'
        'encoding = "utf-8"\n[columns]\nt = "時間"\nY = "横力"\nX = false\nN = false\n[[runs]]\n'
        'id = "a"\ntest = "static_drift"\nfile = "run.csv"\nspeed = 1.0\n',
        encoding="utf-8",
    )
    assert main(["check", str(tmp_path)]) != 0
    said = capsys.readouterr().err
    assert 'encoding = "cp932"' in said
    assert 'encoding = "utf-8"' not in said


def test_the_moment_about_a_rudder_is_no_yaw_moment():
    """Headers of SINTEF Ocean's turns of the SOBC-1."""
    headers = {
        "XPOS": "m", "YPOS": "m", "ROLL": "deg", "YAW": "deg", "TOTAL_SPEED": "m/s",
        "SURGE_SPEED": "m/s", "SWAY_SPEED": "m/s", "GYRO_X": "deg/s", "GYRO_Z": "deg/s",
        "PROPELLER_REV": "Hz", "PROPELLER_TORQUE": "N m", "RUDDER_ANGLE": "deg",
        "FX_RUDDER": "N", "FY_RUDDER": "N", "MZ_RUDDER": "N m", "FAN_THRUST": "N",
    }  # fmt: skip
    found = suggest(list(headers), list(headers.values()), {})
    assert [item.name if item else None for item in found] == [
        "x", "y", "phi", "psi", "speed", "u", "v", "p", "r", "n", "Q", "delta", "FX_rudder",
        "FY_rudder", None, None,
    ]  # fmt: skip
    # with a balance beside it
    both = suggest(["MZ_RUDDER", "MZ"], ["N m", "N m"], {})
    assert [item.name if item else None for item in both] == [None, "N"]
