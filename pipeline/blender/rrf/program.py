"""`rrf` as a process of its own: started, watched, stopped."""

import queue
import re
import subprocess
import threading

from . import settings


class ProgramMissing(Exception):
    """The program was not found."""

    def __init__(self):
        super().__init__("The program rrf was not found. Name its place in the add-on's preferences")


class ProgramFailed(Exception):
    """The program ended with an error."""


def command(*words):
    found = settings.program()
    if not found:
        raise ProgramMissing
    return [found, *words]


def call(*words):
    """Runs the program to its end; what it printed."""
    done = subprocess.run(command(*words), capture_output=True, text=True)
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        raise ProgramFailed(lines[-1] if lines else f"rrf ended with exit code {done.returncode}")
    return done.stdout


class Running:
    """A process, and the lines that it has printed."""

    def __init__(self, *words):
        self.process = subprocess.Popen(
            command(*words), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
        )
        self.lines = queue.Queue()
        self.last = ""
        # a pipe that nobody empties would stop the program
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.put(line)

    def news(self):
        """The newest line that says something, if there is one since the last call."""
        newest = None
        while not self.lines.empty():
            # without the control sequences of a terminal
            text = re.sub(r"\x1b\[[0-9;]*[A-Za-z]", "", self.lines.get()).strip()
            newest = text or newest
        self.last = newest or self.last
        return newest

    def done(self):
        """The exit code, once it has ended and all that it printed was read."""
        code = self.process.poll()
        if code is not None:
            self.reader.join()
        return code

    def stop(self):
        """Asks it to end; what it has finished is kept, and `--resume` goes on from there."""
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
