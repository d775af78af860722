"""Run a command beside busy processes: `python -m tests.busy 6 -- make test`. Its exit code is the command's."""

import subprocess
import sys


def main() -> int:
    """Start so many busy processes, run the command, and end them."""
    if len(sys.argv) < 4 or not sys.argv[1].isdecimal() or sys.argv[2] != "--":
        print(f"expected: python -m tests.busy COUNT -- COMMAND\nfound: {' '.join(sys.argv[1:])}", file=sys.stderr)
        return 2
    # Each ends by itself when its standard input does, so also if this process is killed.
    watch = "import os, threading; threading.Thread(target=lambda: os._exit(len(os.read(0, 1)))).start()"
    command = [sys.executable, "-S", "-c", f"{watch}\nwhile True: pass"]
    busy = [subprocess.Popen(command, stdin=subprocess.PIPE) for _ in range(int(sys.argv[1]))]
    try:
        return subprocess.run(sys.argv[3:], check=False).returncode
    finally:
        for process in busy:
            process.kill()
            process.wait()


if __name__ == "__main__":
    sys.exit(main())
