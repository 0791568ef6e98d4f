"""Every command of README and docs is run as it is shown, or is listed with the reason why not.

The commands are collected from the Markdown itself. Each page is a story: its commands are run in their order, in a
copy of the checkout, beside a simulated kite where they talk to one.
"""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.docs import how_they_run
from tests.docs.how_they_run import ENDLESS, KEEPS_FLYING, MENTIONS, NOT_RUN, PROGRAMS_NOT_RUN, SOAK
from tests.docs.markdown_commands import EXAMPLES, PAGES, ROOT, Shown, shown_on
from tests.docs.workshop import Workshop

pytest.importorskip("matplotlib")
STORIES = (*PAGES, *EXAMPLES)


@pytest.fixture
def checkout_untouched() -> Iterator[None]:
    """Nothing is left behind."""
    def names() -> list[Path]:
        return [path for folder in (ROOT, ROOT / "docs", ROOT / "docs" / "figures") for path in folder.iterdir()]

    before = names()
    yield
    assert [name for name in names() if name not in before] == []


def why_not_run(command: Shown, real_time: bool) -> str | None:
    """The reason why `command` is not run, if there is one."""
    if command.is_python:
        return how_they_run.PYTHON_IS_SOAK if command.calls_a_kite and not real_time else None
    if command.text in MENTIONS:
        return "a mention"
    program = command.text.split()[0]
    reason = NOT_RUN.get(command.text) or PROGRAMS_NOT_RUN.get(program)
    return reason or (None if real_time else SOAK.get(command.text))


def tell(page: str, folder: Path, real_time: bool) -> None:
    """Run the commands of `page` in their order; fail with all that went wrong."""
    commands = [command for command in shown_on(page) if not why_not_run(command, real_time)]
    problems = []
    workshop = Workshop(folder, real_time)
    try:
        if any("kite-ground" in command.text or command.calls_a_kite or "make sitl" in command.text
               for command in commands):
            workshop.fly()
        if any("kite-ground replay" in command.text for command in commands):
            workshop.record_long()
        for command in commands:
            if command.text == "make sitl":
                continue  # flying since the story began
            if command.text in KEEPS_FLYING:
                workshop.keep_flying(command.text, KEEPS_FLYING[command.text])
                continue
            problem = workshop.run_python(command.text) if command.is_python else workshop.run(command.text)
            if problem:
                problems.append(f"{command.where}: {problem}")
    finally:
        workshop.close()
    assert not problems, "\n\n".join(problems)


@pytest.mark.parametrize("page", STORIES)
def test_the_commands_of_a_page_do_what_they_are_there_for(page, tmp_path, checkout_untouched):
    tell(page, tmp_path, real_time=False)


def test_what_is_said_about_commands_is_said_about_commands_that_are_shown():
    shown = {command.text for page in STORIES for command in shown_on(page)}
    told = [*NOT_RUN, *SOAK, *ENDLESS, *KEEPS_FLYING, *how_they_run.APPENDED, *how_they_run.SHORTER,
            *how_they_run.ANSWERS, *how_they_run.BEFORE]
    assert [text for text in told if text not in shown] == []
    assert len(shown) > 80  # and they are found at all


def test_a_command_that_fails_is_noticed(tmp_path):
    workshop = Workshop(tmp_path, real_time=False)
    assert "no scenario no-such" in (workshop.run("kite-sitl run no-such") or "")
    assert "Traceback" in (workshop.run("python -c 'nonsense' || true") or "")
    assert workshop.run("kite-sitl list") is None
