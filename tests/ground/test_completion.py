"""Completion in the shell: what a person gets on Tab, asked of a real bash."""

import shutil
import subprocess

import pytest

from ground.cli.main import main


@pytest.fixture
def script(capsys, tmp_path):
    """The script for a shell, in a file."""
    def make(shell: str):
        assert main(["completion", shell]) == 0
        path = tmp_path / shell
        path.write_text(capsys.readouterr().out)
        return path

    return make


def on_tab(script, folder, *words: str) -> list[str]:
    """What bash offers after these words."""
    lines = [f"source {script}", 'COMP_WORDS=("$@"); COMP_CWORD=$(($#-1)); _shtab_kite_ground; echo "${COMPREPLY[@]}"']
    return subprocess.run(["bash", "-c", "\n".join(lines), "bash", "kite-ground", *words], cwd=folder, check=True,
                          capture_output=True, text=True).stdout.split()


@pytest.mark.skipif(not shutil.which("bash"), reason="no bash here")
def test_bash_completes_commands_parameters_and_files(script, tmp_path):
    bash = script("bash")
    (tmp_path / "mine.param").touch()
    assert on_tab(bash, tmp_path, "para") == ["param"]
    assert on_tab(bash, tmp_path, "param", "sa") == ["save", "savechanged"]
    assert on_tab(bash, tmp_path, "param", "set", "inn") == ["INNER_P"]
    assert on_tab(bash, tmp_path, "--link", "udpout:1.2.3.4:5", "param", "revert", "OUTER") == ["OUTER_L"]
    assert on_tab(bash, tmp_path, "param", "load", "mi") == ["mine.param"]
    assert on_tab(bash, tmp_path, "mode", "tr") == ["track"]


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_get_a_script_with_the_names_in_it(script, shell):
    path = script(shell)
    assert "INNER_P" in path.read_text() and "savechanged" in path.read_text()
    if shutil.which(shell):
        subprocess.run([shell, "-n", str(path)], check=True)
