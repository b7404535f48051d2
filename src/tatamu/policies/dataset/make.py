"""Make a dataset: record the missing episodes, then write the finished files."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from concurrent.futures import Executor, Future, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from itertools import islice
from pathlib import Path

from tatamu.base.errors import UnavailableError
from tatamu.base.extras import needed
from tatamu.base.files import write_text, writing
from tatamu.base.version import __version__
from tatamu.evaluation.disturbances import load_disturbances
from tatamu.lerobot.video import check_codec
from tatamu.policies.dataset.arms import Stand, find_stand
from tatamu.policies.dataset.demonstrations import writing_demonstrations
from tatamu.policies.dataset.episode import Episode, Recorder, record_episode
from tatamu.policies.dataset.folder import DatasetFolder, DatasetRecord
from tatamu.policies.dataset.page import page
from tatamu.policies.dataset.record import EpisodeRecord, row_of, with_shares, write_table
from tatamu.policies.dataset.sources import DrawnFold, check_names, draw_fold, parameters_of, read_runs
from tatamu.policies.dataset.specification import DatasetSpecification, read_specification
from tatamu.policies.dataset.states import Extent, StateWriter, extend
from tatamu.simulation.side_by_side import executor_of, processors
from tatamu.simulation.simulators import require

Progress = Callable[[int, int], None]
"""Called with the number of recorded episodes and of all episodes."""
UNDER_WAY = 64
"""Largest number of episodes that are submitted to the executor but not yet stored."""


def make_dataset(
    specification: DatasetSpecification | Path | str,
    out: Path | str,
    *,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> DatasetFolder:
    """Make or resume a dataset. A finished dataset with the same specification is not changed.

    Args:
        specification: The specification, or its file.
        out: Folder of the dataset.
        executor: Executor that records the episodes; None for threads of this process, one for each processor.
        progress: Function that is called after every episode.

    Raises:
        InputError: If the specification is wrong, a package is missing, or the folder contains something else.
        UnavailableError: If workers or the disk fail. Recorded episodes remain stored.
    """
    if not isinstance(specification, DatasetSpecification):
        specification = read_specification(Path(specification))
    folder = DatasetFolder(Path(out))
    if folder.is_finished:
        folder.refuse_other(DatasetRecord(specification=specification))
        progress(specification.episodes, specification.episodes)
        return folder
    runs = _check(specification)
    with folder.locked():
        folder.start(DatasetRecord(specification=specification))
        stand = _find_stand(specification, runs)
        recorder = Recorder(specification, runs, load_disturbances(specification.disturbances), stand)
        with executor_of(executor, processors()) as workers:
            _record(recorder, folder, workers, progress)
        _write(recorder, folder)
    return folder


def _check(specification: DatasetSpecification) -> list[DrawnFold]:
    """Refuse what cannot be recorded before the first episode, and return the learned folds."""
    load_disturbances(specification.disturbances)
    needed("pyarrow", "dataset")
    if "zarr" in specification.formats:
        needed("zarr", "dataset")
    if specification.cameras:
        check_codec()
    if specification.outcome.simulator is not None:
        require(specification.outcome.simulator)
    runs = read_runs(specification)
    if not runs:
        check_names(specification)
    return runs


def _find_stand(specification: DatasetSpecification, runs: list[DrawnFold]) -> Stand | None:
    """Place the first fold, with the largest garment that may be drawn; None for floating hands."""
    if specification.robot is None:
        return None
    drawn = draw_fold(specification, runs, 0)
    largest = specification.drawn_garment.largest
    subject = drawn.subject if largest is None else drawn.subject.model_copy(update={"size": [*largest]})
    task = subject.make_task()
    return find_stand(specification.robot, task.manipulation(parameters_of(drawn, task, 0.0)))


def _record(recorder: Recorder, folder: DatasetFolder, workers: Executor, progress: Progress) -> None:
    """Record all episodes that are not stored yet."""
    total = recorder.specification.episodes
    missing = iter([number for number in range(total) if not folder.episode_file(number).exists()])
    done = sum(folder.episode_file(number).exists() for number in range(total))
    progress(done, total)
    futures: set[Future[Episode]] = set()

    def submit(count: int) -> None:
        futures.update(workers.submit(record_episode, recorder, number) for number in islice(missing, count))

    try:
        submit(UNDER_WAY)
        while futures:
            ended = next(as_completed(futures))
            futures.discard(ended)
            folder.keep(ended.result())
            done += 1
            progress(done, total)
            submit(1)
    except BrokenProcessPool:
        raise UnavailableError(f"{folder.path}: a worker process died; run the same command again to resume") from None
    finally:
        for future in futures:
            future.cancel()


def _write(recorder: Recorder, folder: DatasetFolder) -> None:
    """Write the finished files of the dataset from the stored episodes."""
    specification = recorder.specification
    building = folder.building
    with writing(building):
        shutil.rmtree(building, ignore_errors=True)
        building.mkdir(parents=True)
    plain: list[EpisodeRecord] = []
    extents: dict[str, Extent] = {}
    counts: set[int] = set()  # of key points
    for number in range(specification.episodes):  # needed of all episodes before the first finished file is written
        episode = folder.kept(number)
        plain.append(episode.record)
        counts.add(episode.arrays["key_points"].shape[1])
        extend(extents, episode)
    records = with_shares(plain, recorder.disturbances is not None)
    rows, pictures = [], []
    writers: list[Callable[[Episode], None]] = []
    with ExitStack() as stack:
        if "zarr" in specification.formats:
            about = {"fps": specification.record.fps, "tatamu": __version__}
            writers.append(StateWriter(building / folder.states.name, len(records), extents, about).add)
        if "lerobot" in specification.formats:
            key_points = counts.pop() if len(counts) == 1 else None
            first = folder.kept(0)
            demonstrations = writing_demonstrations(building, specification, recorder.stand, first, key_points)
            writers.append(stack.enter_context(demonstrations))
        for record in records:
            episode = Episode(record, folder.kept(record.episode).arrays)
            rows.append(row_of(record, episode.arrays["final"]))
            pictures += [episode.arrays["thumbnail"]] if "thumbnail" in episode.arrays else []
            for write in writers:
                write(episode)
    write_table(building / folder.table.name, rows)
    about_all = DatasetRecord(
        specification=specification,
        stand=recorder.stand,
        episodes=len(records),
        frames=sum(each.frames for each in records),
        successes=sum(each.success for each in records),
    )
    write_text(building / folder.page.name, page(about_all, records, pictures))
    folder.finish(about_all)
