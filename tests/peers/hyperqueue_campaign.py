"""Carries a campaign out on HyperQueue, server and workers on this computer.

    hyperqueue_campaign.py "$(softdock campaign hq DIR --shards N)"
"""

import shlex
import sys

from hyperqueue import Job, LocalCluster
from hyperqueue.cluster import WorkerConfig

words = shlex.split(sys.argv[1])
split = words.index("--")
options, command = words[:split], words[split + 1 :]
first, last = map(int, options[options.index("--array") + 1].split("-"))
assert first == 0, "HyperQueue counts the tasks of a job from 0"

with LocalCluster() as cluster:
    for _ in range(2):
        cluster.start_worker(WorkerConfig(cores=1))
    client = cluster.client()
    job = Job(max_fails=None)
    for _ in range(first, last + 1):
        job.program(command, stdout=None, stderr=None)
    submitted = client.submit(job)
    print("submitted", flush=True)
    client.wait_for_jobs([submitted])
print("finished", flush=True)
