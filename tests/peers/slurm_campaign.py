"""Carries a campaign out on a Slurm of two nodes, both on this computer, and loses one of them on the way.

    slurm_campaign.py FOLDER DIR "$(softdock campaign slurm DIR --shards N)"

It needs root and the packages slurmctld, slurmd, slurm-client and munge; without, it prints `FORBIDDEN` and why.
"""

import os
import pathlib
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import time

PATIENCE_S = 400
# A node that does not answer for so long is lost.
NODE_TIMEOUT_S = 10

folder = pathlib.Path(sys.argv[1]).resolve()
campaign = pathlib.Path(sys.argv[2])
line = shlex.split(sys.argv[3])
running = []


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def configure():
    for name in ["state", "spool-n1", "spool-n2", "munge"]:
        (folder / name).mkdir(parents=True, exist_ok=True)
    os.chmod(folder / "munge", 0o700)
    key = folder / "munge/key"
    key.write_bytes(os.urandom(128))
    key.chmod(0o600)
    host = socket.gethostname().split(".")[0]
    nodes = "\n".join(
        f"NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={free_port()} CPUs=1"
        for name in ["n1", "n2"]
    )
    config = folder / "slurm.conf"
    config.write_text(
        f"""ClusterName=loopback
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/linear
ReturnToService=2
SlurmdTimeout={NODE_TIMEOUT_S}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
{nodes}
PartitionName=all Nodes=ALL Default=YES State=UP MaxTime=INFINITE
"""
    )
    os.environ["SLURM_CONF"] = str(config)


def start(*command):
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    running.append(process)
    return process


def ask(*command):
    return subprocess.run(command, capture_output=True, text=True, check=False)


def wait(what, condition):
    give_up = time.monotonic() + PATIENCE_S
    while not condition():
        if time.monotonic() > give_up:
            log = (folder / "slurmctld.log").read_text()[-3000:]
            raise SystemExit(f"waited {PATIENCE_S} s for {what}\n{ask('squeue').stdout}{ask('sinfo').stdout}{log}")
        time.sleep(0.2)


def of_node(name):
    """Processes of the jobs on a node, and of their supervisors (slurmstepd)."""
    found = set()
    for entry in pathlib.Path("/proc").iterdir():
        try:
            environment = (entry / "environ").read_bytes().split(b"\0")
            if f"SLURM_CONF={folder}/slurm.conf".encode() not in environment:
                continue
            if f"SLURMD_NODENAME={name}".encode() not in environment:
                continue
            found.add(int(entry.name))
            parent = (entry / "stat").read_text().rsplit(")", 1)[1].split()[1]
            if (pathlib.Path("/proc") / parent / "comm").read_text().startswith("slurmstepd"):
                found.add(int(parent))
        except (OSError, ValueError):
            continue
    return found


def parts():
    return len(list(campaign.glob("part-*.parquet")))


def carry_out():
    configure()
    munge = folder / "munge"
    start(
        shutil.which("munged", path="/usr/sbin:/usr/bin"), "--foreground", "--force",
        f"--key-file={munge}/key", f"--socket={munge}/socket", f"--pid-file={munge}/pid",
        f"--log-file={munge}/log", f"--seed-file={munge}/seed",
    )
    wait("munged", (munge / "socket").exists)
    start("/usr/sbin/slurmctld", "-D", "-i")
    start("/usr/sbin/slurmd", "-D", "-N", "n1")
    lost = start("/usr/sbin/slurmd", "-D", "-N", "n2")
    wait("two idle nodes", lambda: ask("sinfo", "-h", "-N", "-o", "%T").stdout.split() == ["idle", "idle"])

    submitted = subprocess.run(line, check=True, capture_output=True, text=True).stdout
    print(submitted.strip(), flush=True)
    wait("the first parts", lambda: parts() >= 2 and of_node("n2"))
    lost.kill()
    for process in of_node("n2"):
        try:
            os.kill(process, signal.SIGKILL)
        except ProcessLookupError:
            pass
    print("node n2 lost", flush=True)

    def over():
        # A task that was lost is held for two minutes; nobody here needs them.
        for held in ask("squeue", "-h", "-r", "-t", "PD", "-o", "%i %r").stdout.splitlines():
            task, reason = held.split(" ", 1)
            if reason == "BeginTime":
                ask("scontrol", "update", f"JobId={task}", "StartTime=now")
        return ask("squeue", "-h").stdout == ""

    wait("the rest", over)
    print("finished", flush=True)


if os.geteuid() != 0:
    print("FORBIDDEN Slurm: only root can start its daemons", flush=True)
elif not all(shutil.which(name, path="/usr/sbin:/usr/bin") for name in ["slurmctld", "slurmd", "munged", "sbatch"]):
    print("FORBIDDEN Slurm: slurmctld, slurmd, slurm-client or munge is not installed", flush=True)
else:
    try:
        carry_out()
    finally:
        for process in reversed(running):
            process.terminate()
        for process in running:
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
