"""The tutorial of one's own scene: its commands, run in order, print what it shows."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from service.cli.app import app

PAGE = Path(__file__).parents[3] / "docs" / "tutorial" / "your-scene.md"
BLOCKS = re.findall(r"```(yaml|sh|text)\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


@pytest.fixture
def run(tmp_path, monkeypatch, real_server):
    """Run the commands of a block; return their output as one line, however it was wrapped."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("WAYPROOF_SERVER", real_server.url)

    def carry_out(commands):
        told = []
        for line in commands.splitlines():
            program, *words = shlex.split(line)
            assert program == "wayproof"
            answer = CliRunner().invoke(app, words)
            told.append(answer.stdout + answer.stderr)
        return " ".join("\n".join(told).split())

    return carry_out


def lines(text):
    return [" ".join(line.split()) for line in text.splitlines()]


def test_commands_print_what_the_page_shows(run):
    kinds, texts = zip(*BLOCKS, strict=True)
    assert kinds == ("yaml", "sh", "text", "sh", "text", "sh", "text", "text")
    scene, check, invalid, plan, failed, again, valid, misspelt = texts
    file = Path("shelf.scene.yaml")
    file.write_text(scene)
    told = run(check)
    assert all(line in told for line in lines(invalid)), told
    told = run(plan)
    assert all(line in told for line in lines(failed)), told
    mended = scene.replace("[0.55, 0.0, 0.4]", "[0.55, 0.0, 0.8]")
    assert mended != scene
    file.write_text(mended)
    told = run(again)
    assert all(line in told for line in lines(valid)), told
    assert "check: clearance │ passed" in told
    assert Path("motion.html").stat().st_size > 10_000
    file.write_text(mended.replace("shape: {box: [0.3", "shap: {box: [0.3"))
    told = run(plan)
    assert all(line in told for line in lines(misspelt)), told
