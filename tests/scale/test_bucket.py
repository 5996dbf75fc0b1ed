"""Datasets in an object store: an S3 server on the loopback. Nothing is lost, faults are clear, the bytes are those on disk."""

import json
import os
import random
import signal
import subprocess
import time

import pytest
import sheetlight.scale
from conftest import FULL, KEYS, FaultyProxy, assert_same, command, files, run, tiny, tiny_arguments, wait_until
from sheetlight import _gen
from sheetlight.scale.store import Store

URL = "s3://planks/some/where"
PLACE = "some/where"


def test_bytes_are_those_of_one_gen(bucket, reference):
    done = sheetlight.scale.generate(**tiny(5, samples_per_shard=2), url=URL, engine="local")
    wanted = reference(5, 2)
    assert_same(bucket.files(PLACE), wanted)
    assert (done["samples"], done["shards"], done["made_shards"], done["made_samples"]) == (5, 3, 3, 5)
    assert done["bytes"] == sum(len(content) for path, content in wanted.items() if path not in ("README.md", "croissant.json"))


def test_a_part_from_a_file_takes_its_assets_along(bucket, tmp_path):
    changes = {"scan.columns": 64, "scan.profiles": 48}
    _gen.run(["--recipe", "mesh-small", *_gen.set_arguments(changes), "--n", "2", "--out", str(tmp_path / "parts")])
    sheetlight.scale.generate("mesh-small", 2, URL, "local", overrides=changes)
    found = bucket.files(PLACE)
    assert_same(found, files(tmp_path / "parts"))
    (asset,) = [path for path in found if path.startswith("assets/")]
    bucket.client().put_object(Bucket="planks", Key=f"{PLACE}/{asset}", Body=b"another mesh")
    bucket.client().delete_object(Bucket="planks", Key=f"{PLACE}/shards/00000.json")
    refused = run("task", URL, status=2)
    assert "is not the file that the dataset was begun with" in refused.stderr and asset in refused.stderr


def test_killed_and_continued(bucket, reference, logged):
    """Drivers are killed at drawn moments; what was finished is not made again, and the last one finishes."""
    n, chance = (60 if FULL else 8), random.Random(18)
    killed = 0
    while len(bucket.manifests(PLACE)) < n // 2 and killed < 10:
        before = bucket.manifests(PLACE)
        asked_before = len(logged())
        driver = subprocess.Popen(command("generate", URL, "--engine", "local", *tiny_arguments(n)), start_new_session=True)
        wanted = len(before) + 1
        wait_until(lambda: len(bucket.manifests(PLACE)) >= wanted or driver.poll() is not None)
        time.sleep(chance.uniform(0, 0.4))
        os.killpg(driver.pid, signal.SIGKILL)
        killed += driver.wait() == -signal.SIGKILL
        asked = {int(part.partition("/")[0]) for part, what, *_ in logged()[asked_before:] if what == "begun"}
        assert not before & asked
    assert killed >= 1
    before, asked_before = bucket.manifests(PLACE), len(logged())
    run("generate", URL, "--engine", "local", *tiny_arguments(n))
    asked = {int(part.partition("/")[0]) for part, what, *_ in logged()[asked_before:] if what == "begun"}
    assert not before & asked
    assert_same(bucket.files(PLACE), reference(n))


def test_two_writers_at_once(bucket, reference):
    n = 40 if FULL else 6
    writers = [subprocess.Popen(command("generate", URL, "--engine", "local", *tiny_arguments(n))) for _ in range(2)]
    assert [writer.wait() for writer in writers] == [0, 0]
    assert_same(bucket.files(PLACE), reference(n))


def test_of_two_that_begin_at_once_one_wins(bucket):
    """Twelve beginners of two datasets: those of one win, the others are refused."""
    beginners = {
        seed: [
            subprocess.Popen(command("begin", URL, *tiny_arguments(3), "--seed", seed), stderr=subprocess.PIPE, text=True)
            for _ in range(6 if FULL else 2)
        ]
        for seed in (1, 2)
    }
    ended = {seed: [(one.wait(), one.stderr.read()) for one in ones] for seed, ones in beginners.items()}
    seed = json.loads(bucket.files(PLACE)["dataset.json"])["seed"]
    assert {status for status, _ in ended[seed]} == {0}
    assert {status for status, _ in ended[3 - seed]} == {2}
    assert all(f"seed: {seed} -> {3 - seed}" in words for _, words in ended[3 - seed])


def test_requests_that_fail_or_are_late(bucket, reference, monkeypatch):
    """A tenth of all requests meets a fault; nothing is lost, and every kind of fault occurs."""
    n = 100 if FULL else 14
    proxy = FaultyProxy(bucket.port, 0.1, seed=18)
    monkeypatch.setenv("AWS_ENDPOINT_URL", proxy.endpoint)
    done = run("generate", URL, "--engine", "local", "--json", *tiny_arguments(n))
    met = proxy.stop()
    assert json.loads(done.stdout)["samples"] == n
    assert_same(bucket.files(PLACE), reference(n))
    faults = {name: count for name, count in met.items() if name != "none"}
    assert len(faults) == 5, met
    assert 0.05 < sum(faults.values()) / sum(met.values()) < 0.2, met


def test_a_store_without_conditional_puts(bucket, reference, monkeypatch):
    """It is looked at first: what is there is compared and refused all the same."""
    proxy = FaultyProxy(bucket.port, 0.0, 1, "plain")
    monkeypatch.setenv("AWS_ENDPOINT_URL", proxy.endpoint)
    sheetlight.scale.generate(**tiny(2), url=URL, engine="local")
    assert_same(bucket.files(PLACE), reference(2))
    assert not Store(URL).create("dataset.json", b"another")
    assert "seed: 0 -> 1" in run("begin", URL, *tiny_arguments(2), "--seed", "1", status=2).stderr
    assert_same(bucket.files(PLACE), reference(2))
    assert proxy.stop()["condition"] >= 2


@pytest.mark.skipif(not FULL, reason="SCALE_FULL=1 uploads 120 MB through the faulty proxy")
def test_a_file_in_parts_through_requests_that_fail(bucket, tmp_path, monkeypatch):
    content = random.Random(1).randbytes(120_000_000)
    (tmp_path / "large").write_bytes(content)
    proxy = FaultyProxy(bucket.port, 0.1, seed=5)
    monkeypatch.setenv("AWS_ENDPOINT_URL", proxy.endpoint)
    for number in range(3):
        Store(f"s3://planks/{number}").upload(tmp_path, ["large"])
    met = proxy.stop()
    assert sum(count for name, count in met.items() if name != "none") > 0, met
    for number in range(3):
        assert bucket.files(str(number))["large"] == content


def test_a_store_that_is_gone_is_told_and_may_be_tried_again(bucket, monkeypatch):
    monkeypatch.setattr("sheetlight.scale.store.ATTEMPTS", 2)
    proxy = FaultyProxy(bucket.port, 1.0, seed=1)
    proxy.stop()
    monkeypatch.setenv("AWS_ENDPOINT_URL", proxy.endpoint)
    monkeypatch.setenv("AWS_MAX_ATTEMPTS", "1")
    with pytest.raises(sheetlight.scale.Interruption, match=f"{URL}/dataset.json: cannot read it after 2 attempts"):
        sheetlight.scale.status(URL)


def test_missing_bucket(bucket):
    for asked in (["begin", *tiny_arguments(2)], ["status"], ["task"], ["finish"]):
        refused = run(asked[0], "s3://no-such-bucket/planks", *asked[1:], status=2)
        assert "s3://no-such-bucket/planks" in refused.stderr and "there is no such bucket" in refused.stderr


def test_wrong_credentials_and_a_bucket_that_can_only_be_read(bucket, reference):
    """The server knows one user, who may read and list."""
    sheetlight.scale.generate(**tiny(2), url=URL, engine="local")
    users = bucket.client("iam")
    users.create_user(UserName="reader")
    keys = users.create_access_key(UserName="reader")["AccessKey"]
    may = {"Effect": "Allow", "Action": ["s3:GetObject", "s3:ListBucket"], "Resource": "*"}
    policy = json.dumps({"Version": "2012-10-17", "Statement": [may]})
    users.put_user_policy(UserName="reader", PolicyName="reads", PolicyDocument=policy)
    bucket.require_keys()
    secret = keys["SecretAccessKey"]
    reader = {"AWS_ACCESS_KEY_ID": keys["AccessKeyId"], "AWS_SECRET_ACCESS_KEY": secret}

    assert "2 of 2 shards" in run("status", URL, **reader).stdout
    writes = [
        ["generate", URL, "--engine", "local", *tiny_arguments(4)],
        ["begin", "s3://planks/new", *tiny_arguments(2)],
        ["finish", URL],
    ]
    for asked in writes:
        refused = run(*asked, status=2, **reader).stderr
        assert "cannot write it" in refused and "check the credentials" in refused and secret not in refused

    wrong = reader | {"AWS_SECRET_ACCESS_KEY": "wrong-secret-of-forty-letters-0123456789"}
    unknown = KEYS | {"AWS_ACCESS_KEY_ID": "AKIAUNKNOWN"}
    for keys in (wrong, unknown):
        refused = run("status", URL, status=2, **keys).stderr
        assert "cannot read it" in refused and "check the credentials" in refused
        assert keys["AWS_SECRET_ACCESS_KEY"] not in refused
    bucket.let_everybody()
    assert_same(bucket.files(PLACE), reference(2))


def test_no_credentials_at_all(bucket, tmp_path, monkeypatch):
    for name in KEYS:
        monkeypatch.delenv(name)
    nothing = {"AWS_EC2_METADATA_DISABLED": "true", "HOME": str(tmp_path)}
    assert "check the credentials in the environment" in run("status", URL, status=2, **nothing).stderr


def test_a_larger_n_extends_also_where_the_last_shard_was_not_full(bucket, reference):
    for n in (3, 5, 4):
        done = sheetlight.scale.generate(**tiny(n, samples_per_shard=2), url=URL, engine="local")
        assert done["samples"] == max(n, 3 if n == 3 else 5)
        assert_same(bucket.files(PLACE), reference(done["samples"], 2))


def test_lost_and_damaged_files_are_made_again(bucket, reference):
    """Of one shard a file is lost, of another one it is cut, a third one's manifest is of a smaller dataset."""
    sheetlight.scale.generate(**tiny(4, samples_per_shard=2), url=URL, engine="local")
    client, wanted = bucket.client(), reference(4, 2)
    lost, cut = (next(path for path in wanted if path.startswith(f"exr/0000{shard}")) for shard in (0, 1))
    client.delete_object(Bucket="planks", Key=f"{PLACE}/{lost}")
    client.put_object(Bucket="planks", Key=f"{PLACE}/{cut}", Body=wanted[cut][:-1])
    told = run("finish", URL, status=1).stderr
    assert "2 shards" in told and "0, 1" in told
    done = sheetlight.scale.generate(**tiny(4, samples_per_shard=2), url=URL, engine="local")
    assert done["made_shards"] == 2
    assert_same(bucket.files(PLACE), wanted)

    old = reference(3, 2)
    client.put_object(Bucket="planks", Key=f"{PLACE}/shards/00001.json", Body=old["shards/00001.json"])
    assert sheetlight.scale.generate(**tiny(4, samples_per_shard=2), url=URL, engine="local")["made_shards"] == 1
    assert_same(bucket.files(PLACE), wanted)
