"""The errors that tatamu raises on purpose, as a tree.

TatamuError
├── InputError         a file, an option or a scene is wrong; the command line exits with 2
└── SimulationError    a rollout passed a limit of its model (stretch, speed, not finite)
"""


class TatamuError(Exception):
    """Base of every error that tatamu raises on purpose; its text is one line that a person can act on."""


class InputError(TatamuError):
    """A given file, option or value is wrong; says what was given, what is allowed and, if known, what to do."""


class SimulationError(TatamuError):
    """A rollout left the range in which its simulator is valid."""
