"""Slurm for a test: a controller and two nodes as processes of this machine, where Debian's slurmctld, slurmd and munge are."""

import getpass
import os
import shutil
import signal
import socket
import subprocess
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol")
CONF = """
ClusterName=test
SlurmctldHost={host}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
SlurmctldPort={ports[0]}
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,bf_interval=1
SlurmdTimeout=10
SlurmctldTimeout=10
ReturnToService=2
KillWait=5
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=1 State=UNKNOWN
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=1 State=UNKNOWN
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""


def missing() -> list[str]:
    """Programs that are not installed."""
    paths = os.environ["PATH"] + ":/usr/sbin:/sbin"
    return [name for name in PROGRAMS if shutil.which(name, path=paths) is None]


class Slurm:
    """The running cluster; `environment` is for its clients."""

    def __init__(self, folder: Path, ports: list[int]):
        self.folder, self.nodes = folder, {}
        folder.chmod(0o755)
        (folder / "state").mkdir()
        self.conf = folder / "slurm.conf"
        self.conf.write_text(CONF.format(host=socket.gethostname(), user=getpass.getuser(), folder=folder, ports=ports))
        path = os.environ["PATH"] + ":/usr/sbin:/sbin"
        self.environment = os.environ | {"SLURM_CONF": str(self.conf), "PATH": path}
        (folder / "munge.key").write_bytes(os.urandom(128))
        (folder / "munge.key").chmod(0o400)
        names = {"key-file": "key", "socket": "socket", "pid-file": "pid", "log-file": "log", "seed-file": "seed"}
        options = [f"--{option}={folder / f'munge.{name}'}" for option, name in names.items()]
        munge = ["munged", "--foreground", "--force", *options]
        self.services = [self._start(munge), self._start(["slurmctld", "-D", "-f", str(self.conf)])]
        for name in ("n1", "n2"):
            self.start_node(name)

    def start_node(self, name: str) -> None:
        self.nodes[name] = self._start(["slurmd", "-D", "-f", str(self.conf), "-N", name])

    def kill_node(self, name: str) -> None:
        """As a machine that loses its power: slurmd, the jobs on it, and the slurmstepd of each."""
        self.nodes[name].kill()
        self.nodes.pop(name).wait()
        jobs = [process for process in Path("/proc").glob("[0-9]*") if self._is_on(process, name)]
        above = [Path("/proc", _parent(job)) for job in jobs]
        # First those that would tell the controller that their job has failed.
        for process in [*(one for one in above if b"slurmstepd" in _content(one / "cmdline")), *jobs]:
            _kill(process)

    def _is_on(self, process: Path, node: str) -> bool:
        """Whether a process belongs to a job on that node of this cluster."""
        environment = _content(process / "environ").split(b"\0")
        return f"SLURMD_NODENAME={node}".encode() in environment and f"SLURM_CONF={self.conf}".encode() in environment

    def ask(self, *arguments: str) -> str:
        """What a client of Slurm says."""
        return subprocess.run(arguments, env=self.environment, capture_output=True, text=True, check=True).stdout

    def stop(self) -> None:
        for process in [*self.nodes.values(), *reversed(self.services)]:
            process.terminate()
        for process in [*self.nodes.values(), *reversed(self.services)]:
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()

    def _start(self, arguments: list[str]) -> subprocess.Popen:
        log = (self.folder / f"{Path(arguments[0]).name}.out").open("ab")
        return subprocess.Popen(arguments, env=self.environment, stdout=log, stderr=log, cwd=self.folder)


def _content(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError:
        return b""


def _parent(process: Path) -> str:
    lines = _content(process / "status").decode().splitlines()
    return next((line.split()[1] for line in lines if line.startswith("PPid:")), "self")


def _kill(process: Path) -> None:
    try:
        os.kill(int(process.name), signal.SIGKILL)
    except (ValueError, ProcessLookupError):
        pass
