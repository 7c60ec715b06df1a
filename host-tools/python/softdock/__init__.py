"""Recordings of docking rigs: read, compare with a model, diagnose.

Everything here is done by the program ``softdock``; answers are its ``--json`` documents.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sysconfig
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = ["SoftdockError", "compare", "diagnose", "program", "read", "run", "series"]

PathLike = Union[str, "os.PathLike[str]"]


class SoftdockError(RuntimeError):
    """What the program said when it could not do what was asked."""


def program() -> str:
    """The path of the program: the one of this environment, else the one on PATH."""
    found = shutil.which("softdock", path=sysconfig.get_path("scripts")) or shutil.which("softdock")
    if found is None:
        raise SoftdockError("the program softdock is neither in this environment nor on PATH: pip install softdock")
    return found


def run(*arguments: PathLike) -> dict[str, Any]:
    """Any command of the program, as its JSON document: ``run("effects")``."""
    command = [program(), *map(os.fspath, arguments), "--json"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8")
    try:
        answer = json.loads(done.stdout) if done.stdout else {}
    except ValueError:
        answer = {"error": done.stdout.strip()}
    if done.returncode != 0:
        raise SoftdockError(answer.get("error") or done.stderr.strip())
    return answer


def read(recording: PathLike) -> DataFrame:
    """A recording, a row for each cycle; the index is the time in s. Column names end with the unit."""
    return _table("export", recording, "-o")


def series(model: PathLike, recording: PathLike) -> DataFrame:
    """Measured, predicted, residual and sigma of each channel and axis; the index is the time in s."""
    return _table("compare", model, recording, "--series")


def compare(model: PathLike, recording: PathLike) -> dict[str, Any]:
    """How large the model's error is (``channels``, ``phases``) and, in a sentence, ``where``."""
    return run("compare", model, recording)


def diagnose(model: PathLike, train: PathLike, test: PathLike | None = None) -> dict[str, Any]:
    """What the model lacks: ``verdict``, ``effects``, ``parameters``; the error on ``test``, if it is given."""
    unseen = () if test is None else ("--test", test)
    return run("diagnose", model, train, *unseen)


def _table(*command: PathLike) -> DataFrame:
    """The table that a command writes into the file that is named last."""
    import pandas

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "table.csv"
        run(*command, file)
        return pandas.read_csv(file, index_col=0)
