#!/usr/bin/env python3
"""The program from outside: batches on clusters. Usage: clusters_test.py PROGRAM [unittest arguments]. Standard library only."""
import os, pathlib, random, shutil, subprocess, time, unittest

from program import PROGRAM, Folder, atropos


class Clusters(Folder):
    """The Snakefile: on this machine, and through a Slurm of our own on this machine. Needs snakemake, slurmctld, slurmd, munge."""

    ROOT = pathlib.Path(__file__).resolve().parents[2]

    def snakemake(self, profile, **environment):
        if not shutil.which("snakemake"):
            self.skipTest("no snakemake here")
        atropos("experiment", self.experiment, "-o", self.folder / "one", "--quiet", check=0)
        done = subprocess.run(["snakemake", "-s", self.ROOT / "experiments/Snakefile", "--profile", self.ROOT / "experiments/profiles" / profile, "--config",
                               f"experiment={self.experiment}", f"output={self.folder / 'whole'}", "shards=2", f"atropos={PROGRAM}"],
                              capture_output=True, text=True, cwd=self.folder, timeout=500, env=os.environ | environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertSameFolders(self.folder / "one", self.folder / "whole")

    def test_of_one_machine_give_the_same_bytes(self):
        self.snakemake("local")

    def test_of_slurm_give_the_same_bytes(self):
        """munge, slurmctld and slurmd in a folder of their own, as root, one node; skips where they can't start."""
        if os.geteuid() != 0 or not all(shutil.which(p) for p in ("munged", "slurmctld", "slurmd", "sbatch", "sinfo")):
            self.skipTest("needs root, munge, slurmctld, slurmd and slurm-client")
        slurm = self.folder / "slurm"
        for name in ("", "munge", "state", "spool"):
            (slurm / name).mkdir(mode=0o755)
        os.chmod(self.folder, 0o755)
        (slurm / "munge/key").write_bytes(random.randbytes(128))
        os.chmod(slurm / "munge/key", 0o400)
        (slurm / "slurm.conf").write_text(f"""
ClusterName=test
SlurmctldHost=localhost
SlurmUser=root
AuthInfo=socket={slurm}/munge/socket
SlurmctldPort=16817
SlurmdPort=16818
SlurmctldPidFile={slurm}/slurmctld.pid
SlurmdPidFile={slurm}/slurmd.pid
StateSaveLocation={slurm}/state
SlurmdSpoolDir={slurm}/spool
SlurmctldLogFile={slurm}/slurmctld.log
SlurmdLogFile={slurm}/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
ReturnToService=2
NodeName=localhost NodeAddr=127.0.0.1 CPUs=2 RealMemory=4096
PartitionName=all Nodes=localhost Default=YES MaxTime=INFINITE State=UP
""")
        environment = {"SLURM_CONF": str(slurm / "slurm.conf")}
        daemons = []
        try:
            for command in (["munged", "--force", "--foreground", f"--socket={slurm}/munge/socket", f"--key-file={slurm}/munge/key",
                             f"--pid-file={slurm}/munge/pid", f"--log-file={slurm}/munge/log", f"--seed-file={slurm}/munge/seed"],
                            ["slurmctld", "-D", "-f", slurm / "slurm.conf"], ["slurmd", "-D", "-f", slurm / "slurm.conf", "-N", "localhost"]):
                daemons.append(subprocess.Popen(command, env=os.environ | environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
                time.sleep(2)
            for _ in range(20):
                state = subprocess.run(["sinfo", "-h", "-o", "%t"], capture_output=True, text=True, env=os.environ | environment).stdout.strip()
                if state == "idle" or any(d.poll() is not None for d in daemons):
                    break
                time.sleep(1)
            if state != "idle":
                log = slurm / "slurmd.log"
                self.skipTest("slurmd can't start here: " + (log.read_text().splitlines()[-1] if log.exists() and log.read_text() else state))
            self.snakemake("slurm", **environment)
        finally:
            for daemon in reversed(daemons):
                daemon.terminate()
                daemon.wait(timeout=30)


if __name__ == "__main__":
    unittest.main()
