"""The manoeuvres, their metrics and what the IMO asks of them, as tables of the registries."""

from __future__ import annotations

from pmmkit.conventions import METRICS, Criterion, Metric
from pmmkit.simulation import MANOEUVRES, Setting
from scripts.documentation.fences import table


def manoeuvre_table() -> str:
    """The manoeuvres with their settings."""
    rows = [
        (f"`{item.name}`", item.title, ", ".join(setting_words(one) for one in item.settings))
        for item in MANOEUVRES.values()
    ]
    return table(("`--manoeuvre`", "", "settings, with their defaults"), rows)


def setting_words(setting: Setting) -> str:
    """A setting with its default and what it is."""
    unit = "°" if setting.unit == "deg" else "" if setting.unit == "-" else f" {setting.unit}"
    default = "" if setting.default is None else f" {setting.default:g}{unit}"
    return f"`{setting.name}`{default} ({setting.text})"


def metric_table() -> str:
    """The metrics with the manoeuvres that give them."""
    return table(
        ("metric", "symbol", "what it is", "unit", "manoeuvres"),
        (
            (f"`{metric.name.format('N')}`", metric.symbol, words(metric), metric.unit, of(metric))
            for metric in METRICS.values()
        ),
    )


def words(metric: Metric) -> str:
    """The long name, with who has it and the side to which it counts."""
    notes = ["of a ship that rolls"] * metric.rolls + ["to starboard"] * metric.starboard
    return ", ".join([metric.title, *notes])


def of(metric: Metric) -> str:
    """The manoeuvres that give a metric."""
    given = [
        f"`{item.name}`"
        for item in MANOEUVRES.values()
        if any(one.name == metric.name for one in item.metrics)
    ]
    return ", ".join(given) or "sea trials alone"


def criterion_table() -> str:
    """What the IMO asks for."""
    return table(
        ("criterion", "paragraph", "manoeuvre", "metric", "at most"),
        (
            (
                item.name.replace("_", " "),
                item.paragraph,
                ", ".join([item.manoeuvre.replace("_", " "), *angles(item)]),
                f"`{metric.judged(item)}`",
                limit(metric, item),
            )
            for metric, item in METRICS.criteria
        ),
    )


def angles(criterion: Criterion) -> list[str]:
    """The angles of the manoeuvre, rudder over heading."""
    found = [f"{x:g}°" for name, x in criterion.settings.items() if name.endswith("_deg")]
    return ["/".join(found)] if found else []


def limit(metric: Metric, criterion: Criterion) -> str:
    """The limit, or where it begins and ends over L/V."""
    if not callable(criterion.limit):
        return f"{criterion.limit:g}" + (" L" if metric.length else "°")
    low, high = criterion.limit(0.0), criterion.limit(1e3)
    slope = criterion.limit(21.0) - criterion.limit(20.0)
    level = criterion.limit(20.0) - 20.0 * slope
    return f"{low:g}°; ({level:g} + {slope:g} L/V)° from L/V = 10 s; {high:g}° from 30 s"


TABLES = {
    "simulate.md": {"manoeuvres": manoeuvre_table, "metrics": metric_table},
    "imo.md": {"criteria": criterion_table},
}
