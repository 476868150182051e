"""One rule for what a command writes: ``--out`` is a folder, ``-o`` a file."""

import pytest

from pmmkit.actions import action, names
from pmmkit.actions.jobs.card import CardSettings
from pmmkit.actions.shared import Out, Output

SAID = {"out": Out.__metadata__[0], "output": Output.__metadata__[0]}


@pytest.mark.parametrize("name", names())
def test_a_folder_is_named_with_out_and_a_file_with_o_as_declared_once(name):
    for item in action(name).fields:
        written = {"--out", "-o", "--output"} & set(item.options)
        if item.name in SAID or written:
            assert item.help is SAID[item.name]
            assert item.group == ""
    assert SAID["output"].names == "-o --output"
    assert SAID["out"].text.startswith("Folder")


@pytest.mark.parametrize(
    ("do", "wrong", "why"),
    [
        ("fit", {"output": "a.toml"}, "name it with --out"),
        ("form", {"out": "a"}, "name it with -o"),
    ],
)
def test_a_card_says_which_of_the_two_it_takes(do, wrong, why):
    card = action("card")
    assert set(SAID) <= {item.name for item in card.fields}
    assert CardSettings in {type(card.asked({"action": do, **wrong}))}
    with pytest.raises(ValueError, match=why):
        card.do(card.asked({"action": do, "what": "kvlcc2", **wrong}))
