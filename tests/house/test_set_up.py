"""What the scripts install: the tools for the tests, and those for the documentation site."""

from __future__ import annotations

import json

import pytest

from scripts.set_up import environment


@pytest.fixture
def installed(monkeypatch, tmp_path):
    """What would be installed, one list a time; an environment that is made already."""
    commands: list[list[str]] = []
    monkeypatch.setattr(environment, "STAMP", tmp_path / "stamp.json")
    monkeypatch.setattr(environment, "version", lambda python: environment.OLDEST)
    monkeypatch.setattr(environment, "_can_install", lambda: True)
    monkeypatch.setattr(environment, "_run", commands.append)
    return commands


def test_the_site_asks_for_its_extra_once_and_keeps_the_tools_of_the_tests(installed):
    environment.ensure(development=True)
    environment.ensure()
    environment.ensure(documentation=True)
    environment.ensure(development=True, documentation=True)
    tests, site = installed
    assert str(environment.ROOT) in tests
    assert any(item.startswith("pytest") for item in tests)
    assert f"{environment.ROOT}[docs]" in site
    assert any(item.startswith("pytest") for item in site)


def test_an_environment_of_an_older_stamp_is_brought_up_to_date(installed):
    environment.STAMP.write_text(json.dumps({"fingerprint": "old", "development": True}))
    environment.ensure(documentation=True)
    (command,) = installed
    assert f"{environment.ROOT}[docs]" in command
    assert any(item.startswith("pytest") for item in command)
