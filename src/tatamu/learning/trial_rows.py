"""A finished trial as rows of Optuna's tables, written in one transaction of a few statements.

Optuna's own `Study.add_trial` looks each parameter and each attribute up before it writes it, some forty statements for
a trial of ours: more time than a proposal takes. The rows are the same.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from optuna.distributions import distribution_to_json
from optuna.storages import RDBStorage
from optuna.storages._rdb.models import (
    TrialModel,
    TrialParamModel,
    TrialSystemAttributeModel,
    TrialUserAttributeModel,
    TrialValueModel,
)
from optuna.trial import FrozenTrial
from sqlalchemy import insert
from sqlalchemy.orm import Session


def write_trial(storage: RDBStorage, study_id: int, trial: FrozenTrial) -> None:
    """Add a finished trial to a study that nobody else writes at this moment.

    Args:
        storage: Where the study is.
        study_id: Of the study in the storage.
        trial: The trial, with the number that it shall have.
    """
    row = TrialModel(
        study_id=study_id,
        number=trial.number,
        state=trial.state,
        datetime_start=trial.datetime_start,
        datetime_complete=trial.datetime_complete,
    )
    with Session(storage.engine) as session, session.begin():
        session.add(row)
        session.flush()  # gives it its trial_id
        for model, rows in _belonging(trial).items():
            if rows:
                session.connection().execute(insert(model), [{"trial_id": row.trial_id, **each} for each in rows])


def _belonging(trial: FrozenTrial) -> dict[Any, list[dict[str, Any]]]:
    """The rows of other tables that belong to a trial, by table."""
    value, value_type = TrialValueModel.value_to_stored_repr(trial.values[0])
    return {
        TrialValueModel: [{"objective": 0, "value": value, "value_type": value_type}],
        TrialParamModel: [
            {
                "param_name": name,
                "param_value": trial.distributions[name].to_internal_repr(given),
                "distribution_json": distribution_to_json(trial.distributions[name]),
            }
            for name, given in trial.params.items()
        ],
        TrialUserAttributeModel: _attributes(trial.user_attrs),
        TrialSystemAttributeModel: _attributes(trial.system_attrs),
    }


def _attributes(held: Mapping[str, Any]) -> list[dict[str, Any]]:
    return [{"key": key, "value_json": json.dumps(value)} for key, value in held.items()]
