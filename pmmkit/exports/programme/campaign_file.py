"""The campaign file beside a programme, which reads what comes back without a change."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pmmkit.campaigns import Campaign
from pmmkit.exports.campaign_csv import campaign_tables, listed
from pmmkit.exports.text import written_by
from pmmkit.files import toml_text
from pmmkit.syntax import comment


def programme_text(
    campaign: Campaign,
    entries: Sequence[Mapping[str, Any]],
    said: Sequence[str],
    tables: Mapping[str, Mapping[str, Any]],
) -> str:
    """The text of ``campaign.toml`` for runs that are still to be made.

    campaign: ship, water and what else is known before. entries: of ``[[runs]]``. said: comments.
    tables: what is stated beside that, or in place of it, such as ``axes``.
    """
    known = campaign_tables(campaign)
    merged = {**known, **{name: {**known.get(name, {}), **own} for name, own in tables.items()}}
    merged["campaign"] = {**merged["campaign"], "planned": True}
    data = {name: table for name, table in merged.items() if table}
    data |= {"runs": list(_of_their_own(entries)), "end": {}}
    lines = [*written_by("#"), *(line for text in said for line in comment(text, "#"))]
    return "\n".join(lines) + "\n\n" + toml_text(listed(data))


def _of_their_own(entries: Sequence[Mapping[str, Any]]) -> Iterator[dict[str, Any]]:
    """Entries that name no run but those beside them: one of older tests is in another file."""
    ids = {entry["id"] for entry in entries}
    for entry in entries:
        alone = entry.get("repeat_of") not in ids
        yield {name: x for name, x in entry.items() if not (alone and name == "repeat_of")}
