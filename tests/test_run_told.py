"""What a run was told stays with its results."""

import shlex
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from mimeline.run import NAME, Run, recall, remember

CONFIG = {"data_dir": None, "select": {"max_s": 10.0}}


def test_what_a_run_was_told_is_recalled(tmp_path):
    files = [Path.cwd() / "config" / "mine.yaml", Path("/elsewhere/more.yaml")]
    remember(tmp_path / "results", CONFIG, files, ["data_dir=my takes", "select={min_s: 2}"])
    run = recall(tmp_path / "results")
    assert run.config == CONFIG
    assert run.file == "/elsewhere/more.yaml"
    assert run.command("--forcerun", "fetch") == (
        "snakemake --cores 2 --forcerun fetch --configfile config/mine.yaml /elsewhere/more.yaml "
        "--config 'data_dir=my takes' 'select={min_s: 2}'"
    )


def test_a_change_joins_what_was_given_before():
    run = Run(CONFIG, given=("data_dir=takes",))
    assert run.file == "config/config.yaml"
    changed = run.command(select={"exclusions": "out.csv"})
    assert changed == "snakemake --cores 2 --config data_dir=takes 'select={exclusions: out.csv}'"
    again = Run(CONFIG, given=("select={max_s: 12}", "shards=4"))
    changed = again.command(select={"exclusions": "my list.csv"})
    assert changed.endswith("--config 'select={max_s: 12, exclusions: my list.csv}' shards=4")


@given(st.lists(st.text(min_size=1).filter(lambda text: "\0" not in text)))
def test_a_shell_reads_the_command_as_it_was_given(texts):
    command = Run(CONFIG, given=tuple(texts)).command()
    assert shlex.split(command)[4:] == texts if texts else "--config" not in command


def test_of_results_that_tell_nothing_nothing_is_made_up(tmp_path):
    assert recall(tmp_path) == Run({})
    for content in ("", "[]", '{"config": 1}', '{"config": [1], "files": [], "given": []}'):
        (tmp_path / NAME).write_text(content)
        assert recall(tmp_path) == Run({})
