"""Work on other processes: the same results, whatever happens to the workers."""

from __future__ import annotations

import gc
import math
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn

import cloudpickle
import numpy as np
import pytest
from studies.real_cloth.__main__ import app
from studies.real_cloth.bench import Bench, Experiment
from studies.real_cloth.matsudaira import models
from typer.testing import CliRunner

from tatamu.base.errors import InputError, UnavailableError, WorkerKilledError
from tatamu.cluster import connected, executor_at
from tatamu.cluster.connection import CERTIFICATES, OLDEST_DASK, parse_address
from tatamu.cluster.executor import LARGE, DaskExecutor, SharedArguments
from tatamu.cluster.versions import checked_call, difference, versions
from tatamu.cluster.watch import Patience, Watch
from tatamu.evaluation.evaluator import Ask
from tatamu.evaluation.nominal import Nominal
from tatamu.folding.task import make_task
from tatamu.study.loop import _timed
from tests.commands import refused
from tests.oldest import PROJECT
from tests.scenes import scene
from tests.small_studies import X, bytes_in, learn_plain, timeless, towel
from tests.test_real_cloth import write_fabrics

LONGEST = 1800.0
"""Time after which a call is taken for lost, on a machine however busy [s]."""


@pytest.fixture(scope="module")
def executor() -> Iterator[DaskExecutor]:
    with connected("local:2") as found:
        yield found


def die_once(mark: Path) -> int:
    if not mark.exists():
        mark.touch()
        os._exit(1)
    return os.getpid()


def die(mark: Path) -> NoReturn:
    with mark.open("a") as file:
        file.write("x")
    os._exit(1)


def hang_once(mark: Path) -> int:
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGSTOP)
    return os.getpid()


class Once(Patience):
    """Gives up on the calls that run when a file appears, and on no call after that."""

    def __init__(self, mark: Path) -> None:
        super().__init__()
        self.mark: Path | None = mark

    def limit(self, longest: float | None) -> float:
        if self.mark is None or not self.mark.exists():
            return math.inf
        self.mark = None
        return 0.0


def wait_for(mark: Path) -> bool:
    while not mark.exists():
        time.sleep(0.01)
    return True


def nap(seconds: float) -> float:
    time.sleep(seconds)
    return seconds


def loaded(array: np.ndarray, times: int) -> tuple[int, int]:
    return os.getpid(), int(array[0]) * times


@pytest.mark.parametrize(
    "given", ["tcp:10.0.0.1", "local:0", "local:x", "http://a:1", "tcp://a:99999", "tcp://a b:1", ""]
)
def test_what_is_no_address_is_refused(given: str) -> None:
    with pytest.raises(InputError, match="--scheduler"):
        parse_address(given)


def test_addresses_are_read() -> None:
    assert parse_address("local:4").local == 4
    assert parse_address("tcp://10.0.0.5:8786").local is None
    assert parse_address("tls://[::1]:8786").text == "tls://[::1]:8786"


def test_no_address_is_no_executor() -> None:
    with executor_at(None) as found:
        assert found is None


def test_a_scheduler_that_is_not_there_is_refused_within_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tatamu.cluster.connection.CONNECT_SECONDS", 0.5)
    with pytest.raises(UnavailableError, match=r"tcp://127\.0\.0\.1:9 does not answer \(.* after 0\.5 s\)"):
        with connected("tcp://127.0.0.1:9"):
            pass


def certificate(folder: Path) -> Path:
    """A certificate that signs itself, and its key beside it."""
    if shutil.which("openssl") is None:
        pytest.skip("openssl is not installed")
    names = ["-keyout", str(folder / "key.pem"), "-out", str(folder / "cert.pem"), "-days", "2", "-subj", "/CN=lab"]
    made = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", *names]
    subprocess.run(made, check=True, capture_output=True)
    return folder / "cert.pem"


def test_a_scheduler_with_certificates_is_reached_with_them_alone(tmp_path: Path) -> None:
    import dask
    import distributed

    said = r"needs certificates; set .*ca-file in the Dask configuration"
    with pytest.raises(InputError, match=said):
        with connected("tls://127.0.0.1:9"):
            pass
    with dask.config.set({name: "/nowhere" for name in CERTIFICATES}):
        with pytest.raises(
            InputError, match=r"ca-file in the Dask configuration must name an existing file, given /nowhere"
        ):
            with connected("tls://127.0.0.1:9"):
                pass
    cert = str(certificate(tmp_path))
    files = {"cert": cert, "key": str(tmp_path / "key.pem")}
    named = {f"distributed.comm.tls.{role}": files for role in ("scheduler", "worker", "client")}
    with dask.config.set({"distributed.comm.tls.ca-file": cert, **named}):
        with distributed.LocalCluster(n_workers=1, protocol="tls", dashboard_address=":0", processes=False) as cluster:
            with connected(cluster.scheduler_address) as executor:
                assert cluster.scheduler_address.startswith("tls://")
                assert executor.submit(divmod, 7, 2).result() == (3, 1)


def test_calls_come_back_with_results_and_errors(executor: DaskExecutor) -> None:
    assert list(executor.map(divmod, range(4), [2] * 4)) == [divmod(k, 2) for k in range(4)]
    with pytest.raises(ZeroDivisionError):
        executor.submit(divmod, 1, 0).result()


def test_results_that_were_given_over_are_not_kept(executor: DaskExecutor) -> None:
    answers = [executor.submit(nap, 0.0) for _ in range(4)]
    assert [answer.result(LONGEST) for answer in answers] == [0.0] * 4
    for _ in range(18000):
        gc.collect()
        if not [key for key in executor._client.futures if key.startswith("checked_call")]:
            return
        time.sleep(0.1)
    pytest.fail("the workers keep them, and compute them again if they die")


def test_large_arguments_go_over_once(executor: DaskExecutor) -> None:
    array = np.full(100_000, 7.0)
    twin = array.copy()
    before = len(executor._shared._futures)
    results = [executor.submit(loaded, each, times).result() for each in (array, twin) for times in range(3)]
    assert [product for _, product in results] == [0, 7, 14] * 2
    assert len(executor._shared._futures) - before == 1, "equal content is one argument"


def test_shared_arguments_that_were_not_used_for_longest_are_forgotten(executor: DaskExecutor) -> None:
    shared = SharedArguments(executor._client, kept=2_000_000)
    first, second, third = (np.full(100_000, value) for value in (1.0, 2.0, 3.0))
    held = shared.replaced(first).key
    other = shared.replaced(second).key
    assert shared.replaced(first).key == held and other != held
    assert list(shared._futures) == [held, other]
    newest = shared.replaced(third).key
    assert list(shared._futures) == [held, newest], "the second was used before the first"
    assert executor.submit(loaded, third, 2).result()[1] == 6


def test_an_evaluator_is_shared_and_parameters_go_along_with_their_call() -> None:
    evaluator = Nominal(make_task("towel", spacing=0.013))
    assert len(cloudpickle.dumps(X)) < LARGE < len(cloudpickle.dumps(evaluator))


def test_what_is_bound_to_a_function_goes_over_once(executor: DaskExecutor) -> None:
    array = np.full(100_000, 3.0)
    before = len(executor._shared._futures)
    assert [executor.submit(array.item, place).result() for place in range(3)] == [3.0] * 3
    assert len(executor._shared._futures) - before == 1


def test_a_call_whose_worker_dies_runs_elsewhere(executor: DaskExecutor, tmp_path: Path) -> None:
    assert executor.submit(die_once, tmp_path / "mark").result(LONGEST) > 0


def test_a_large_argument_outlives_its_workers(executor: DaskExecutor) -> None:
    array = np.full(100_000, 5.0)
    for times in (1, 2, 3):
        pid, product = executor.submit(loaded, array, times).result(LONGEST)
        assert product == 5 * times
        os.kill(pid, signal.SIGKILL)


def test_a_call_that_kills_three_workers_is_given_up(executor: DaskExecutor, tmp_path: Path) -> None:
    with pytest.raises(WorkerKilledError, match="killed 3 workers"):
        executor.submit(die, tmp_path / "deaths").result(LONGEST)
    assert 1 <= len((tmp_path / "deaths").read_text()) <= 3, "one may have died before, of what was killed above"
    assert executor.submit(nap, 0.0).result(LONGEST) == 0.0, "the others go on"


def test_a_call_whose_worker_hangs_runs_elsewhere(tmp_path: Path) -> None:
    import distributed

    with connected("local:2") as found:
        patient = DaskExecutor(found._client, "local:2", Watch(Once(tmp_path / "mark")))
        assert isinstance(found._client, distributed.Client)
        assert patient.submit(hang_once, tmp_path / "mark").result(LONGEST) > 0
        patient.shutdown()


def test_how_long_a_call_may_take_follows_the_others() -> None:
    patience = Patience(first=100.0, minimum=10.0, factor=5.0)
    assert [patience.limit(longest) for longest in (None, 1.0, 4.0)] == [100.0, 10.0, 20.0]


def test_other_versions_are_named() -> None:
    assert difference(dict(versions())) is None
    assert "numpy 1.0, not " in (difference({**versions(), "numpy": "1.0"}) or "")
    assert "Python missing, not " in (difference({}) or "")
    with pytest.raises(UnavailableError, match="same versions"):
        checked_call({**versions(), "tatamu": "0.0"}, nap, 0.0)


def test_workers_of_other_versions_are_refused(executor: DaskExecutor, monkeypatch: pytest.MonkeyPatch) -> None:
    from tatamu.cluster.connection import refuse_other_versions

    monkeypatch.setattr("tatamu.cluster.versions.versions", lambda: {**versions(), "numpy": "1.26.4"})
    with pytest.raises(
        InputError, match=r"worker tcp://.* has numpy .*, not 1\.26\.4 as on this machine; install the same versions"
    ):
        refuse_other_versions(executor._client, "local:2")


def test_workers_and_schedulers_with_an_old_dask_are_refused(
    executor: DaskExecutor, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker of 2024 dies of the first call, and a client cannot even connect to a scheduler of 2024."""
    from tatamu.cluster.connection import refuse_other_versions

    said = r"runs Dask 2024\.4\.1, but this machine has .*; install the same version"
    old = {"packages": {"distributed": "2024.4.1"}}
    with monkeypatch.context() as patched:
        patched.setattr(executor._client, "get_versions", lambda: {"workers": {"tcp://a:1": old}})
        with pytest.raises(InputError, match=f"local:2: worker tcp://a:1 {said}"):
            refuse_other_versions(executor._client, "local:2")
    scheduler = executor._client.scheduler_info(n_workers=0)["address"]
    with connected(scheduler) as again:
        assert again.submit(nap, 0.0).result(LONGEST) == 0.0
    monkeypatch.setattr("tatamu.cluster.connection.OLDEST_DASK", (9999, 1))
    with pytest.raises(InputError, match=r"the scheduler runs Dask .*, but this machine has .*; install"):
        with connected(scheduler):
            pass


def test_the_oldest_dask_is_that_of_the_extra() -> None:
    year, month = OLDEST_DASK
    assert f'"distributed>={year}.{month}"' in PROJECT.read_text()


def test_a_worker_that_dies_while_its_versions_are_asked_for_is_no_refusal(
    executor: DaskExecutor, monkeypatch: pytest.MonkeyPatch
) -> None:
    from distributed.comm.core import CommClosedError

    from tatamu.cluster.connection import refuse_other_versions

    answers: dict[str, Any] = {"tcp://a:1": CommClosedError("Stream is closed")}
    monkeypatch.setattr(executor._client, "run", lambda *args, **kwargs: answers)
    refuse_other_versions(executor._client, "local:2")
    answers["tcp://a:2"] = ModuleNotFoundError("No module named 'tatamu'")
    with pytest.raises(InputError, match="worker tcp://a:2 cannot run tatamu"):
        refuse_other_versions(executor._client, "local:2")


def test_calls_that_wait_can_be_cancelled(executor: DaskExecutor, tmp_path: Path) -> None:
    futures = [executor.submit(wait_for, tmp_path / "go") for _ in range(12)]
    assert futures[-1].cancel()
    (tmp_path / "go").touch()
    assert all(future.result(LONGEST) for future in futures[:-1])


def test_a_study_on_workers_is_the_study_of_one_machine(executor: DaskExecutor, tmp_path: Path) -> None:
    task = towel()
    options: dict[str, Any] = {"trials": 4, "baselines": True}
    learn_plain(task, tmp_path / "here", **options)
    learn_plain(task, tmp_path / "there", executor, **options)
    assert timeless(tmp_path / "here") == timeless(tmp_path / "there")
    for name in ("manipulation.json", "scene.json"):
        assert (tmp_path / "here" / name).read_bytes() == (tmp_path / "there" / name).read_bytes()
    here, there = (np.load(tmp_path / which / "rollout.npz") for which in ("here", "there"))
    assert here["positions"].tobytes() == there["positions"].tobytes()


@pytest.mark.slow
def test_real_cloth_on_workers_is_that_of_one_machine(tmp_path: Path) -> None:
    data = write_fabrics(tmp_path / "data")
    arguments = ["--data", str(data), "--only", "drape", "--quick", "--out"]
    for options in ([], ["--scheduler", "local:2"]):
        done = CliRunner().invoke(app, [*arguments, str(tmp_path / f"out-{len(options)}"), *options])
        assert done.exit_code == 0, done.output
    here, there = bytes_in(tmp_path / "out-0"), bytes_in(tmp_path / "out-2")
    assert here == there
    assert sum(name.startswith("kept/") for name in here) == len(models("native"))


def test_a_reading_whose_scene_kills_workers_is_said_and_tried_again(executor: DaskExecutor, tmp_path: Path) -> None:
    deadly = Experiment("deadly", scene(duration=0.01), "death", lambda rollout: die(tmp_path / "deaths"))
    bench = Bench("native", tmp_path / "kept", executor=executor)
    assert "killed 3 workers" in bench.measure([deadly])[0]["failed"]
    assert not bytes_in(tmp_path / "kept")


def test_a_rollout_comes_only_where_it_may_be_kept() -> None:
    evaluator = Nominal(towel())
    kept = _timed(evaluator, Ask(X))
    assert kept.rollout is not None
    worse = _timed(evaluator, Ask(X, beat=kept.objective))
    assert worse.rollout is None and worse.score == kept.score


def test_a_trial_that_kills_its_workers_has_failed_with_its_seed(
    executor: DaskExecutor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    submit = executor.submit
    deaths = iter([0])

    def deadly(function: Any, /, *args: Any, **kwargs: Any) -> Any:
        return submit(die, tmp_path / "deaths") if next(deaths, None) == 0 else submit(function, *args, **kwargs)

    monkeypatch.setattr(executor, "submit", deadly)
    task = towel()
    # one at a time: Dask blames what waits on a worker that dies, too, and may end both after three deaths together
    result = learn_plain(task, tmp_path / "study", executor, trials=3, seed=7, baselines=False, parallel=1)
    trials = result.trials
    assert [trial.state for trial in trials] == ["failed", "complete", "complete"]
    assert "killed 3 workers" in (trials[0].error or "") and "seed 7, first curve" in (trials[0].error or "")


def test_the_command_line_says_in_one_line_that_there_is_no_scheduler(tmp_path: Path) -> None:
    said = refused("learn", "towel", "--out", str(tmp_path / "a"), "--scheduler", "tcp://127.0.0.1:9")
    assert "tcp://127.0.0.1:9" in said
    assert not (tmp_path / "a").exists()
