"""Entry point of `python -m tatamu`, which does the same as the command `tatamu`."""

from tatamu.cli import main

if __name__ == "__main__":
    main()
