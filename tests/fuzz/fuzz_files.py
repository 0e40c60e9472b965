"""Guided fuzzing of what reads files, by atheris: ``make fuzz``.

    PYTHONPATH=.cache/fuzz:tests .venv/bin/python tests/fuzz/fuzz_files.py KIND [SECONDS] [options of libFuzzer]

Half of the files come of libFuzzer's own changes, half of those that the normal suite makes. What is new is kept in
``.cache/fuzz-corpus/KIND``, and the next run begins with it. A file that ends in anything but an error of this project
is left beside as ``KIND-crash-*``; give its name in the place of SECONDS to read it once more.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import atheris

# Code that numba compiles must be as it is written.
COMPILED = ["marine_model.compiled", "marine_model.ventilation", "marine_model.propellers", "marine_model.shaft_limits"]
with atheris.instrument_imports(
    include=["marine_model", "dp_tools", "dp_bringup", "mcap", "rosbags"],
    exclude=COMPILED,
    enable_loader_override=False,
):
    from support.file_fuzz import KINDS, outcome, spoiled

ROOT = Path(__file__).parents[2]
CORPUS = ROOT / ".cache" / "fuzz-corpus"
USUAL = 60  # s


def changed(data: bytes, most: int, seed: int) -> bytes:
    """Change a file of libFuzzer's for it."""
    return bytes(atheris.Mutate(data, most)) if seed % 2 else spoiled(data, seed)[:most]


def main() -> None:
    name = sys.argv[1] if len(sys.argv) > 1 else ""
    if name not in KINDS:
        sys.exit(f"fuzz_files: expected one of {', '.join(KINDS)}, found '{name}'")
    kind = KINDS[name]
    what = sys.argv[2] if len(sys.argv) > 2 else str(USUAL)
    corpus = CORPUS / name
    corpus.mkdir(parents=True, exist_ok=True)
    seeds = kind.seeds()
    for number, seed in enumerate(seeds):
        (corpus / f"seed-{number}").write_bytes(seed)

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"file{kind.suffix}"

        def one(data: bytes) -> None:
            error = outcome(kind, data, path)
            if error is not None and not str(error).strip():
                raise AssertionError(f"refused without a word: {type(error).__name__}")

        options = [f"-max_len={2 * max(map(len, seeds))}", "-timeout=60", "-rss_limit_mb=4096"]
        options += [f"-artifact_prefix={CORPUS}/{name}-", "-print_final_stats=1", *sys.argv[3:]]
        options += [f"-max_total_time={what}", str(corpus)] if what.isdigit() else [what]
        atheris.Setup([sys.argv[0], *options], one, custom_mutator=changed)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
