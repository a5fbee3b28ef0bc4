"""Prints documents again: runs the commands that they show, and puts what comes out in the place of what came out before.

    python tests/python/print_docs.py target/release/contuse docs/error-against-run-time.md [WORD ...]

A command is an indented line that begins with `contuse`; its output is the next block fenced as text. Commands run where the document's
readers are, at the top of the repository. With words, only commands that contain one of them run.
"""

import re
import shlex
import subprocess
import sys
from pathlib import Path

SHOWN = re.compile(r"^    contuse (?P<arguments>.+)\n(?P<between>(?:(?!^    contuse |^```).*\n)*)```text\n(?P<output>(?:(?!^```).*\n)*)```$", re.M)


def main() -> None:
    binary, document, *words = sys.argv[1:]
    path = Path(document)

    def printed(shown: re.Match[str]) -> str:
        arguments = shown["arguments"]
        if words and not any(word in arguments for word in words):
            return shown[0]
        print(f"contuse {arguments}", flush=True)
        run = subprocess.run([binary, *shlex.split(arguments)], capture_output=True, text=True, check=False)
        output = run.stdout.strip("\n")
        if run.returncode != 0 or not output:
            sys.exit(f"contuse {arguments} ended with {run.returncode} and {len(output)} characters:\n{run.stderr}")
        return f"    contuse {arguments}\n{shown['between']}```text\n{output}\n```"

    path.write_text(SHOWN.sub(printed, path.read_text()))


if __name__ == "__main__":
    main()
