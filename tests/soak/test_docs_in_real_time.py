"""The commands of README and docs that need a kite in real time for longer than CI has, and all around them."""

import pytest

from tests.docs.markdown_commands import shown_on
from tests.docs.test_shown_commands import STORIES, tell, why_not_run

NEED_REAL_TIME = [page for page in STORIES if any(
    why_not_run(command, False) and not why_not_run(command, True) for command in shown_on(page))]


@pytest.mark.soak
@pytest.mark.parametrize("page", NEED_REAL_TIME)
def test_the_commands_of_a_page_in_real_time(page, tmp_path):
    tell(page, tmp_path, real_time=True)
