"""A PostgreSQL server of the tests' own, where one is installed: real processes, started, stopped and killed."""

from __future__ import annotations

import os
import pwd
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

PASSWORD = "not-to-be-seen-anywhere"
USER = "folder"
DATABASE = "studies"


@dataclass(frozen=True)
class Server:
    """A server that listens on this machine."""

    programs: Path
    folder: Path
    port: int

    @property
    def address(self) -> str:
        """As `--storage` takes it."""
        return f"postgresql://{USER}@127.0.0.1:{self.port}/{DATABASE}"

    def control(self, *arguments: str) -> None:
        """Call pg_ctl: `start`, `stop -m immediate`, `restart -m fast`."""
        options = f"-p {self.port} -k {self.folder} -c listen_addresses=127.0.0.1 -c fsync=off"
        data = ["-D", str(self.folder / "data"), "-w", "-l", str(self.folder / "log"), "-o", options]
        as_owner([str(self.programs / "pg_ctl"), *arguments, *data])

    def query(self, text: str, database: str = DATABASE) -> str:
        """The answer to a query, as plain text."""
        command = [str(self.programs / "psql"), "-h", "127.0.0.1", "-p", str(self.port), "-U", USER, "-At", "-c", text]
        environment = {**os.environ, "PGPASSWORD": PASSWORD}
        done = subprocess.run([*command, database], env=environment, capture_output=True, text=True, check=True)
        return done.stdout.strip()


def installed() -> Path | None:
    """The folder of PostgreSQL's programs; None where it is not installed or cannot run."""
    folders = sorted(Path("/usr/lib/postgresql").glob("*/bin"), key=lambda path: int(path.parent.name.split(".")[0]))
    if (found := shutil.which("pg_ctl")) is not None:
        folders.append(Path(found).resolve().parent)
    if not folders or (os.getuid() == 0 and shutil.which("setpriv") is None):
        return None
    return folders[-1] if (folders[-1] / "initdb").exists() else None


def owner() -> int:
    """The user that the server runs as: it refuses to be root."""
    if os.getuid() != 0:
        return os.getuid()
    names = {entry.pw_name: entry.pw_uid for entry in pwd.getpwall()}
    return names.get("postgres", names["nobody"])


def as_owner(command: list[str]) -> None:
    """Run a program as the server's user."""
    drop = ["setpriv", f"--reuid={owner()}", "--clear-groups"] if os.getuid() == 0 else []
    subprocess.run([*drop, *command], check=True, stdout=subprocess.DEVNULL, cwd="/tmp")


@contextmanager
def running() -> Iterator[Server]:
    """A server with an empty database, which asks for a password."""
    programs = installed()
    assert programs is not None, "PostgreSQL is installed"
    folder = Path(tempfile.mkdtemp(prefix="tatamu-postgres-"))
    try:
        (folder / "password").write_text(PASSWORD)
        os.chmod(folder / "password", 0o644)
        os.chown(folder, owner(), -1)
        asked = ["--auth=scram-sha-256", f"--pwfile={folder / 'password'}", "--no-sync"]
        as_owner([str(programs / "initdb"), "-D", str(folder / "data"), "-U", USER, *asked])
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            server = Server(programs, folder, free.getsockname()[1])
        server.control("start")
        try:
            server.query(f"CREATE DATABASE {DATABASE}", "postgres")
            yield server
        finally:
            server.control("stop", "-m", "immediate")
    finally:
        shutil.rmtree(folder, ignore_errors=True)
