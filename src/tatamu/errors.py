"""The errors that tatamu raises on purpose, as a tree.

TatamuError
├── InputError              a file, an option or a scene is wrong; the command line exits with 2
│   └── UnavailableError    a scheduler, a database or a disk does not answer; what was finished is kept
└── SimulationError         a rollout passed a limit of its model (stretch, speed, not finite)
    └── WorkerKilledError   a computation that ended the processes it ran in, again and again
"""


class TatamuError(Exception):
    """Base of every error that tatamu raises on purpose; its text is one line that a person can act on."""


class InputError(TatamuError):
    """A given file, option or value is wrong; says what was given, what is allowed and, if known, what to do."""


class UnavailableError(InputError):
    """A scheduler, a database or a disk that the run needs does not answer, or is full; a later run goes on."""


class SimulationError(TatamuError):
    """A rollout left the range in which its simulator is valid."""


class WorkerKilledError(SimulationError):
    """A computation ended the processes it ran in, or never answered, until it was given up."""
